"""Radau's compiled loop: order, stiff modes, work, constraints, their treatments."""

from dataclasses import replace

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared, run
from samples.mechanism_samples import bricard, chain, four_bars, pendulum
from samples.stability_samples import amplitude, hand, stepped
from samples.two_body_samples import stretching_rod, two_bodies

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.math.laws import polynomial
from plymotion.solver.mechanism.tables import ForceTable

DRIVE = polynomial([0.0, 0.0, 3.0, -2.0])
BUSHING = (40.0, 30.0, 20.0, 3.0, 2.0, 1.0, 10.0, 20.0, 30.0, 1.0, 2.0, 3.0)
SAMPLES = {
    "rigid": lambda: chain(2),
    "flexible": lambda: two_bodies(400.0),
    "driven": lambda: two_bodies(400.0, drive=DRIVE),
    "damper": lambda: two_bodies(
        400.0, forces=[ForceTable("d", "spring", 0, 4, (40.0, 30.0, 0.5))]
    ),
    "bushing": lambda: two_bodies(400.0, forces=[ForceTable("b", "bushing", 0, 4, BUSHING)]),
}


def _new(sample, t_end, treatment="projection", name="radau", **options):
    treatment = Treatment(treatment) if isinstance(treatment, str) else treatment
    model, y0 = prepared(sample, treatment)
    return model, new_run(model, y0, treatment, name, t_end, **options)


def _end(sample, t_end, treatment="projection", name="radau", **options):
    """Model and solution at the end."""
    model, made = _new(sample, t_end, treatment, name, **options)
    solution = integrate(made, [0.0, t_end])
    assert solution.status == "finished", solution.message
    return model, solution


@pytest.mark.parametrize("name", SAMPLES)
def test_observed_order_is_five(name):
    """Positions, velocities and the work of drives and dampers, by fixed steps against rk8."""
    t_end, errors = 0.3, []
    _, exact = _end(SAMPLES[name](), t_end, name="rk8", rtol=1e-12, atol=1e-14)
    for n in (6, 12, 24):
        options = {"rtol": 1e-12, "atol": 1e-14, "fixed_step": t_end / n}
        model, solution = _end(SAMPLES[name](), t_end, **options)
        assert solution.counters.steps == n
        d = np.abs(solution.y[-1] - exact.y[-1])
        errors.append([d[: model.n_pos].max(), d[model.n_pos : -1].max(), d[-1]])
    errors = np.array(errors)
    assert errors[-1, 0] < 1e-7
    assert errors[-1, 1] < 1e-6
    does_work = name not in ("rigid", "flexible")
    checked = errors if does_work else errors[:, :2]
    np.testing.assert_allclose(np.log2(checked[:-1] / checked[1:])[-1], 5.0, atol=0.4)
    assert does_work or errors[-1, 2] == 0.0


def test_error_follows_the_tolerance():
    _, exact = _end(two_bodies(400.0), 0.3, name="rk8", rtol=1e-12, atol=1e-14)
    measured = []
    for rtol in (1e-3, 1e-5, 1e-7):
        model, solution = _end(two_bodies(400.0), 0.3, rtol=rtol, atol=1e-2 * rtol)
        measured.append(np.abs(solution.y[-1] - exact.y[-1])[: model.n_pos].max())
        assert measured[-1] < rtol
    assert measured[2] < 1e-3 * measured[0]


@pytest.mark.parametrize("name", ["driven", "damper", "bushing"])
def test_energy_changes_by_the_work(name):
    model, made = _new(SAMPLES[name](), 0.3, rtol=1e-6, atol=1e-8)
    balance = stepped(
        made, lambda i: energies(model, assemble(model, i.t, i.y), i.y).sum() - i.y[-1]
    )
    work = made.y[-1]
    assert abs(work) > 1e-2
    assert np.ptp(balance) < 2e-6 * max(abs(work), 1.0)


def _ignoring_vibration(model, rtol=1e-4):
    """Vibrations under 1e-4 m and 0.1 m/s do not count."""
    atol = np.full(model.n_pos + model.n_vel + 1, 0.1)
    atol[: model.n_pos] = 1e-4
    return {"rtol": rtol, "atol": atol}


def test_steps_and_error_do_not_know_how_stiff_a_mode_is():
    """Two bodies with modes of 1e3 to 1e7 rad/s: the motion of rigid ones, in as many steps."""
    t_end, steps = 0.5, []
    rigid, exact = _end(two_bodies(None), t_end, name="rk8", rtol=1e-11, atol=1e-13)
    _, plain = _end(two_bodies(None), t_end, **_ignoring_vibration(rigid))
    for stiffness in (1e6, 1e8, 1e10, 1e12, 1e14):
        model, _ = _new(two_bodies(stiffness), t_end)
        _, solution = _end(two_bodies(stiffness), t_end, **_ignoring_vibration(model))
        y, second = solution.y[-1], int(model.pos_start[1])
        frames = np.concatenate((y[:7], y[second : second + 7]))
        # what is left is the static bending, and the tolerance
        assert np.abs(frames - exact.y[-1][:14]).max() < 100.0 / stiffness + 1e-5
        steps.append(solution.counters.steps)
        assert np.sqrt(stiffness) * t_end / steps[-1] > 20.0, "the mode is not resolved"
    assert max(steps) <= 2 * plain.counters.steps
    assert np.ptp(steps[1:]) <= 1


def test_stiff_modes_do_not_limit_the_step():
    """As in test_integrators_dae, where generalized-alpha fails: the rod swings 3000 times."""
    _, rigid = _end(stretching_rod(None), 2.0, name="rk8", rtol=1e-9, atol=1e-11)
    for stiffness in (1e8, 1e10):
        _, solution = _end(stretching_rod(stiffness), 2.0, rtol=1e-5, atol=1e-7)
        assert np.abs(solution.y[-1, :7] - rigid.y[-1, :7]).max() < 1e-5
        assert solution.counters.steps < 100
        # the static answer: weight and centrifugal force, at the end
        model = prepared(stretching_rod(stiffness), Treatment())[0]
        y = solution.y[-1]
        sine = 2.0 * (y[3] * y[6] + y[4] * y[5])
        pull = y[model.n_pos + 5] ** 2 - 9.81 * sine
        assert y[7] == pytest.approx(pull / stiffness, rel=1e-3)


def test_an_unresolved_vibration_is_damped_out():
    """The welded hand, every mode displaced, one step of 1/w times 100 and more after another."""
    sample, w = hand("fixed", bent=(1e-6,) * 4)
    model, made = _new(sample, 20 * 100 / w[0], fixed_step=100 / w[0], rtol=1e-6, atol=1e-12)
    assert stepped(made, amplitude(model, 3, w[3]))[-1] < 1e-12
    model, made = _new(sample, 20 * 100 / w[0], fixed_step=100 / w[0], rtol=1e-6, atol=1e-12)
    assert stepped(made, amplitude(model, 0, w[0]))[-1] < 1e-12


@pytest.mark.parametrize(
    "make", [pendulum, lambda: chain(2), bricard, lambda: four_bars(1, core=0.1)]
)
def test_constraints_hold_at_steps_and_between(make):
    sample, times = make(), np.linspace(0.0, 0.3, 23)
    done = run(sample, "projection", times, "radau", rtol=1e-5)
    assert done.solution.status == "finished"
    assert done.position.max() < 1e-10
    for t, y in zip(done.solution.t, done.solution.y, strict=True):
        assert np.abs(assemble(done.model, t, y).Phi).max() < 1e-10
    exact = run(make(), "projection", times, "rk8", rtol=1e-9).solution.y
    n = done.model.n_pos
    assert np.abs(done.solution.y - exact)[:, :n].max() < 1e-5


@pytest.mark.parametrize("treatment", ["index1", "baumgarte", "augmented-lagrangian"])
@pytest.mark.parametrize("make", [pendulum, bricard])
def test_other_treatments_cost_as_many_steps(make, treatment):
    exact = run(make(), "projection", [0.0, 0.3], "rk8", rtol=1e-9).solution.y[-1]
    closed = run(make(), "projection", [0.0, 0.3], "radau", rtol=1e-5)
    done = run(make(), treatment, [0.0, 0.3], "radau", rtol=1e-5)
    assert done.solution.status == "finished"
    assert np.abs(done.solution.y[-1] - exact)[: done.model.n_pos].max() < 1e-5
    tried = done.solution.counters.steps + done.solution.counters.rejected
    assert tried < 1.5 * (closed.solution.counters.steps + 5)


def test_fast_feedback_does_not_disturb_newtons_iteration():
    """alpha h = beta h = 20: explicit methods end at 2."""
    h = 0.02
    treatment = Treatment("baumgarte", alpha=20 / h, beta=20 / h)
    _, made = _new(pendulum(), 2.0, treatment, fixed_step=h, rtol=1e-8, atol=1e-10)
    gap = stepped(made, lambda i: abs(np.linalg.norm(i.y[:3]) - 1.0))
    assert made.status == "finished"
    assert gap.max() < 1e-5
    assert made.counters.evaluations < 30 * made.counters.steps


@pytest.mark.parametrize("options", [{}, {"fixed_step": 0.1}])
def test_rest_remains(options):
    """In equilibrium corrections are of the size of rounding, and converge at no rate."""
    hanging = pendulum()
    along = np.array([-0.6, -0.8, 0.0])
    positions = hanging.start.positions.copy()
    positions[:3] = along
    hanging = replace(
        hanging,
        model=hanging.model._replace(gravity_G=9.81 * along),
        start=hanging.start._replace(positions=positions),
    )
    _, solution = _end(hanging, 2.0, rtol=1e-8, atol=1e-10, **options)
    assert solution.counters.steps + solution.counters.rejected <= 25
    np.testing.assert_allclose(solution.y[-1][:3], along, atol=1e-14)


def test_a_singular_position_is_passed():
    """The four-bar folds flat at 0.6 s and 1.6 s or so; energy and constraints hold."""
    done = run(four_bars(1, core=0.1), "projection", [0.0, 2.0], "radau", rtol=1e-5)
    assert done.solution.status == "finished"
    assert done.monitor.passes
    assert done.position.max() < 1e-10
    assert np.ptp(done.energy) < 1e-3
