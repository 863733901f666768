"""Monitors that look at blocks of steps find what a look at every step finds."""

import json

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.mechanism_samples import bricard, chain, four_bars

from plymotion.solver.checks.constraint_rank import new_observation, note, observe
from plymotion.solver.checks.singularity import SingularityMonitor
from plymotion.solver.dynamics.analysis.rank import begin, new_independence
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.dynamics.tolerances import CERTAIN
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import Steps, integrate
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.preparation import output_times, prepare

MISFIT = 1e-7  # m: the branches turn into each other where the exact mechanism passes


class EveryStep(SingularityMonitor):
    """Reference: takes no certificate, and decomposes the Jacobian at the end of every step."""

    def _seen(self, steps, i=0):
        energy, pivots = super()._seen(steps, i)
        return energy, np.full_like(pivots, -1.0)

    def _adapt(self, pivot, t, y):
        return False


def one_by_one(watch, y0):
    """Show a watch each step by itself, as soon as it is taken."""
    last = y0

    def on_step(i):
        nonlocal last
        steps = Steps(np.array([i.t_old, i.t]), np.stack((last, i.y)), lambda k: i)
        last = i.y
        return watch(steps)

    return on_step


def _same(found, expected):
    assert [f.code for f in found.findings] == [f.code for f in expected.findings]
    for mine, other in zip(found.findings, expected.findings, strict=True):
        assert mine.t == pytest.approx(other.t, rel=1e-7)
        assert mine.text == other.text
    np.testing.assert_allclose(found.passes, expected.passes, rtol=1e-7)
    assert found.energy.in_play == pytest.approx(expected.energy.in_play, rel=1e-12)
    assert found.energy.largest_jump == pytest.approx(expected.energy.largest_jump, abs=1e-12)


@pytest.mark.parametrize(
    ("sample", "treatment", "integrator", "t_end", "stop", "status"),
    [
        (four_bars(2), "projection", "rk8", 1.5, True, "finished"),
        (four_bars(1), "projection", "radau", 1.0, True, "finished"),
        (four_bars(1, core=1e-3), "projection", "gear", 1.0, True, "finished"),
        (four_bars(1), "ggl", "", 1.0, True, "finished"),
        (four_bars(1), "baumgarte", "radau", 1.5, True, "stopped"),
        (four_bars(1), "index1", "rk8", 1.5, True, "stopped"),
        (four_bars(1, MISFIT), "index1", "rk8", 1.0, False, "finished"),
        (four_bars(1, 1e-5), "index1", "rk5", 1.0, True, "finished"),
        (bricard(), "projection", "radau", 2.0, True, "finished"),
        (chain(4, "spherical"), "projection", "radau", 2.0, True, "finished"),
    ],
)
def test_findings_and_times_are_those_of_every_step(
    sample, treatment, integrator, t_end, stop, status
):
    times, runs = np.linspace(0.0, t_end, 7), []
    for kind in (SingularityMonitor, EveryStep):
        treated = Treatment(treatment)
        model, y0 = prepared(sample, treated)
        made = new_run(model, y0, treated, integrator, t_end, rtol=1e-6, atol=1e-8)
        monitor = kind(model, sample.names, treatment, stop=stop)
        monitor.at_start(0.0, y0)
        if kind is SingularityMonitor:
            runs.append((integrate(made, times, watch=monitor), monitor))
        else:
            runs.append((integrate(made, times, one_by_one(monitor, y0)), monitor))
    (block, found), (reference, expected) = runs
    assert block.status == reference.status == status
    _same(found, expected)
    assert block.message == reference.message
    assert block.counters.steps == reference.counters.steps
    np.testing.assert_allclose(block.t, reference.t, rtol=1e-7)
    np.testing.assert_allclose(block.y, reference.y, atol=1e-6 if status == "stopped" else 1e-12)


@pytest.mark.parametrize("integrator", ["radau", "rk8", "gear"])
def test_a_spin_that_stops_a_run_inside_a_stride(integrator, repository, tmp_path):
    """The hand loses its stiffness: the same instant, state and counters, step by step."""
    case = repository / "cases/double-pendulum-limits/case.toml"
    write_case(load_case(case), tmp_path, repository / "tests/packages/double-pendulum-limits")
    file = tmp_path / "runs/isotropic-soft-free.json"
    table = json.loads(file.read_text())
    table["mechanism"]["solver"] |= {"integrator": integrator, "rtol": 1e-4}
    file.write_text(json.dumps(table))
    spec, runs = read_run(file), []
    for blocks in (True, False):
        ready = prepare(spec.mechanism, spec.packages)
        solver = ready.mechanism.solver
        made = make_integrator(ready.model, ready.y0, solver, ready.treatment)
        times = output_times(solver.t_end, solver.output_step)
        if blocks:
            done = integrate(made, times, watch=ready.watch)
        else:
            done = integrate(made, times, one_by_one(ready.watch, ready.y0))
        runs.append((done, ready.spin.findings))
    (block, found), (reference, expected) = runs
    assert block.status == reference.status == "stopped"
    assert found == expected
    assert (block.message, block.code) == (reference.message, reference.code)
    assert block.counters.steps == reference.counters.steps
    assert block.counters.rejected == reference.counters.rejected
    np.testing.assert_array_equal(block.t, reference.t)
    np.testing.assert_allclose(block.y, reference.y, atol=1e-12)


@pytest.mark.parametrize(
    ("integrator", "treatment"),
    [
        ("radau", "projection"),
        ("", "ggl"),
        ("rk8", "projection"),
        ("rk5", "index1"),
        ("gear", "projection"),
    ],
)
@pytest.mark.parametrize(
    "make", [lambda: chain(3), lambda: four_bars(1)], ids=["chain", "four-bar"]
)
def test_watching_changes_no_bit_of_the_motion(make, integrator, treatment):
    sample, times = make(), np.linspace(0.0, 0.9, 37)
    rows = []
    for watched in (True, False):
        treated = Treatment(treatment)
        model, y0 = prepared(sample, treated)
        made = new_run(model, y0, treated, integrator, 0.9, rtol=1e-6, atol=1e-8)
        monitor = SingularityMonitor(model, sample.names, treatment, stop=False)
        monitor.at_start(0.0, y0)
        rows.append(integrate(made, times, watch=monitor if watched else None))
    np.testing.assert_array_equal(rows[0].y, rows[1].y)
    assert rows[0].counters.steps == rows[1].counters.steps


def test_energies_of_a_block_are_those_of_single_states():
    sample = four_bars(2)
    model, y0 = prepared(sample, Treatment())
    made = new_run(model, y0, Treatment(), "radau", 0.3)
    t = np.linspace(0.0, 0.3, 9)
    y = integrate(made, t).y
    states = list(zip(t, y, strict=True))
    expected = [energies(model, assemble(model, *state), state[1]) for state in states]
    found, pivots = np.empty((8, 3)), np.empty(8)
    one = new_observation(model, 8)
    for seen in (one, two := new_observation(model, 8)):
        begin(model, seen.work, seen.rows, 0.0, y0)
    observe(model, one, t[1:], y[1:], found, pivots)
    np.testing.assert_allclose(found, expected[1:], rtol=1e-12, atol=1e-12)
    assert [note(model, two, *state) for state in states[1:]] == [False] * 8
    np.testing.assert_array_equal(two.energy, found)
    np.testing.assert_array_equal(two.pivots, pivots)


@pytest.mark.parametrize("n", [1, 3, 6])
def test_the_least_pivot_bounds_the_smallest_singular_value(n):
    """Of one state: pivots are at least the smallest eigenvalue of C C', and vanish with it."""
    from plymotion.solver.dynamics.elements.constraints.treatment import scaled_jacobian

    model, y0 = prepared(chain(n), Treatment())
    pivot = begin(model, new_workspace(model), new_independence(model), 0.0, y0)
    C = scaled_jacobian(assemble(model, 0.0, y0).Phi_q, model.inertia_scale)
    least = np.linalg.svd(C, compute_uv=False)[-1] ** 2
    assert CERTAIN < least <= pivot * (1 + 1e-12) <= 1 + 1e-12
