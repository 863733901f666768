"""The cutoff of radau: its filter, what it damps, and the rule that sets it against a stall."""

import numpy as np
import pytest
from samples.case_samples import case_runs
from samples.constraint_runs import new_run, prepared
from samples.mechanism_samples import chain
from samples.stability_samples import hand
from samples.two_body_samples import two_bodies

from plymotion.solver.checks.course import stall_findings
from plymotion.solver.checks.finished_run import Look
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.elements.marker import marker_motion
from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.dynamics.evaluation.evaluation import evaluate
from plymotion.solver.dynamics.model.coordinates import moved
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.compiled.cutoff import PASSES, filter_error, start_filter
from plymotion.solver.integrators.compiled.pencil import freeze
from plymotion.solver.integrators.generic.drive import StopRequest, integrate
from plymotion.solver.mechanism.tables import ForceTable
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.preparation import prepare

SPRING = 400.0


def _new(sample, t_end, **options):
    model, y0 = prepared(sample, Treatment("projection"))
    return model, new_run(model, y0, Treatment("projection"), "radau", t_end, **options)


def _length(model, y):
    ends = (marker_motion(model, k, y).x for k in (0, 4))
    return float(np.linalg.norm(np.subtract(*ends)))


def _stiffness(model, y, spring):
    """Modal stiffness, and that of a spring between markers 0 and 4, dense."""
    K = np.zeros((model.n_vel, model.n_vel))
    for i in range(model.n_body):
        m, two, j = int(model.n_mode[i]), int(model.square_start[i]), int(model.vel_start[i]) + 6
        K[j : j + m, j : j + m] = model.K_qq[two : two + m * m].reshape(m, m)
    g = np.zeros(model.n_vel)
    for k in range(model.n_vel):
        for e in (1e-6, -1e-6):
            there = y.copy()
            step = np.where(np.arange(model.n_vel) == k, e, 0.0)
            there[: model.n_pos] = moved(model, y[: model.n_pos], step)
            g[k] += 0.5 * _length(model, there) / e
    return K + spring * np.outer(g, g)


@pytest.mark.parametrize("spring", [0.0, SPRING])
def test_the_filter_solves_its_equations(spring):
    """(w_c^2 M + K) x + Phi_q' mu = w_c^2 M e, Phi_q x = 0, against dense matrices."""
    forces = [ForceTable("s", "spring", 0, 4, (spring, 0.0, 0.5))] if spring else []
    model, made = _new(two_bodies(2000.0, forces=forces), 0.1)
    made.step()
    workspace, y, n, n_c, w_c = made._workspace, made.y, model.n_vel, model.n_constraint, 30.0
    error = np.random.default_rng(3).normal(size=made.n)
    evaluate(model, workspace.work, made.t, y)
    freeze(model, workspace.work, made.t, y, workspace.frozen)
    start_filter(model, workspace.frozen, workspace.cutoff, w_c)
    filter_error(model, workspace.cutoff, w_c, error)
    e = assemble(model, made.t, y)
    K = _stiffness(model, y, spring)
    A = np.block([[w_c**2 * e.M + K, e.Phi_q.T], [e.Phi_q, np.zeros((n_c, n_c))]])
    x = error[model.n_pos : model.n_pos + n]
    for _ in range(PASSES):
        x = np.linalg.solve(A, np.concatenate([w_c**2 * e.M @ x, np.zeros(n_c)]))[:n]
    found = workspace.cutoff.error[model.n_pos : model.n_pos + n]
    np.testing.assert_allclose(found, x, atol=1e-7 * np.abs(x).max())
    assert np.abs(x).max() > 1e-2
    both = workspace.cutoff.error.copy()
    filter_error(model, workspace.cutoff, -w_c, error)  # velocities alone
    np.testing.assert_array_equal(workspace.cutoff.error[model.n_pos :], both[model.n_pos :])
    np.testing.assert_array_equal(workspace.cutoff.error[: model.n_pos], error[: model.n_pos])


def test_rigid_bodies_do_not_notice_a_cutoff():
    ends = []
    for cutoff in (0.0, 1e-3):
        _, made = _new(chain(2), 1.0, rtol=1e-6, atol=1e-8, cutoff_frequency=cutoff)
        ends.append(integrate(made, [1.0]))
    np.testing.assert_allclose(ends[0].y[0, :-1], ends[1].y[0, :-1], atol=1e-8)
    # what an error has across the constraints does not pass the filter
    assert 0.8 < ends[1].counters.steps / ends[0].counters.steps <= 1.0
    assert abs(ends[1].damped_energy) < 1e-7


def test_what_is_damped_is_the_energy_of_the_vibration():
    """The welded hand, two modes displaced: without a cutoff they ring on, with one they end."""
    bent = (1e-4, 0.0, 1e-5)
    sample, w = hand("fixed", bent=bent)
    stored = 0.5 * sum((w[k] * q) ** 2 for k, q in enumerate(bent))
    left, steps = {}, {}
    for cutoff in (0.0, 0.01 * w[0]):
        options = {"rtol": 1e-7, "atol": 1e-9, "cutoff_frequency": cutoff}
        model, made = _new(sample, 300 / w[0], **options)
        solution = integrate(made, [300 / w[0]])
        y = solution.y[-1]
        left[cutoff] = energies(model, assemble(model, 0.0, y), y).sum()
        steps[cutoff] = solution.counters.steps
        lost = solution.damped_energy
        assert left[cutoff] - y[-1] == pytest.approx(stored, rel=1e-3)
    assert left[0.0] == pytest.approx(stored, rel=1e-3)
    assert left[0.01 * w[0]] < 1e-6 * stored
    assert lost == pytest.approx(stored, rel=1e-6)
    assert steps[0.01 * w[0]] < 0.05 * steps[0.0]


def test_a_mode_below_the_cutoff_goes_on():
    """The first mode displaced by 1e-4, the third rings: only the third is damped."""
    sample, w = hand("fixed", bent=(1e-4, 0.0, 1e-6))
    options = {"rtol": 1e-6, "atol": 1e-8, "cutoff_frequency": 5.0 * w[0]}
    t_end = 10 * np.pi / w[0]
    _, made = _new(sample, t_end, **options)
    y = integrate(made, [t_end]).y[-1]
    assert y[7] == pytest.approx(1e-4 * np.cos(w[0] * t_end), abs=2e-7)


@pytest.fixture(scope="module")
def four_bar(repository, tmp_path_factory):
    """The four-bar of the case with its hinge tilted by 1e-3 rad, which snaps at 3.12 s."""
    runs = case_runs(repository, "misaligned-four-bar", tmp_path_factory.mktemp("build"))
    axis = [float(np.sin(1e-3)), 0.0, float(np.cos(1e-3))]
    return read_run(runs / "flexible.json").changed({"joints.C.axis": axis})


@pytest.mark.provokes("vibration-damped")
def test_default_settings_get_through_a_stiff_loop(four_bar):
    """Without the cutoff: 190,000 steps a second from 3.12 s on."""
    result, summary = execute(four_bar.changed({"solver.t_end": 4.0}), progress=False)
    assert summary["completed"]
    assert summary["cost"]["steps"] < 40_000
    (found,) = [w for w in summary["warnings"] if w["code"] == "vibration-damped"]
    assert found["body"] in ("crank", "coupler", "rocker")
    assert 3.1 < found["t"] < 3.3
    assert found["value"] == pytest.approx(10 * np.pi / 0.004)
    assert " of rocker" in found["message"] or " of coupler" in found["message"]
    assert not {"energy-drift", "energy-jump", "branch-change"} & {
        w["code"] for w in summary["warnings"]
    }
    angle = next(s.values for s in result.signals if s.name == "crank_angle")
    assert angle[-1] == pytest.approx(-0.6 * 3.5, abs=1e-6)


class _UntilStalled:
    """Watch that ends a run as soon as it is known to have stalled."""

    def __init__(self, made):
        self.made = made

    def note(self, t, y):
        return bool(self.made.stalls)

    def __call__(self, steps):
        if self.made.stalls:
            return StopRequest(float(steps.t[-1]), "stalled")
        return None


@pytest.mark.provokes("steps-tiny")
@pytest.mark.parametrize(
    ("changes", "words"),
    [({"cutoff_frequency": 0.0}, "cutoff_frequency"), ({"integrator": "gear"}, "max_order = 2")],
)
def test_a_stall_that_is_not_answered_is_explained(four_bar, changes, words):
    """Soon, with body, mode and remedy; what the user has set stays set."""
    spec = four_bar.changed({f"solver.{key}": value for key, value in changes.items()})
    ready = prepare(spec.mechanism, spec.packages)
    made = make_integrator(ready.model, ready.y0, spec.mechanism.solver, ready.treatment)
    told = []
    times = np.linspace(0.0, 12.0, 1201)
    solution = integrate(made, times, watch=_UntilStalled(made), on_stall=told.append)
    assert solution.status == "stopped"
    assert made.counters.steps + made.counters.rejected < 15_000
    assert len(told) == 1
    assert solution.damped_energy == 0.0
    finished = ready.finished(solution, made.order, Look())
    (finding,) = stall_findings(finished)
    assert finding.code == "steps-tiny"
    assert finding.body in ("crank", "coupler", "rocker")
    assert f"of {finding.body}" in finding.text
    assert words in finding.text
    assert told[0].rate > 1e4
