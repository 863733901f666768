"""Singular positions: passed by the exact branch, or ended with words that name the cause."""

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared, run
from samples.mechanism_samples import bricard, chain, four_bars
from scipy.integrate import solve_ivp

from plymotion.solver.checks.singularity import SingularityMonitor
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import by_blocks, derivative
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.table import new_integrator

ALL_JOINTS = ["foot 0", "foot 1", "left 0", "right 0"]


REFERENCE = "a02_n_four_bar"


def _passes(n, t_end):
    """Times at which parallel uprights of N = n are horizontal, from their own equation."""
    pull = 9.81 * (3 * (n + 1) + 6 * n) / (2 * (n + 1) + 6 * n)
    motion = solve_ivp(
        lambda _, z: [z[1], -pull * np.cos(z[0])],
        (0.0, t_end),
        [np.pi / 2, -1.0],
        events=lambda _, z: np.sin(z[0]),
        rtol=1e-12,
        atol=1e-12,
    )
    return motion.t_events[0]


@pytest.mark.parametrize(
    ("name", "integrator", "rtol", "core"),
    [
        ("projection", "rk8", 1e-6, 0.0),
        ("projection", "rk8", 1e-8, 0.0),
        ("projection", "gear", 1e-7, 1e-3),
        ("projection", "rk8", 1e-6, 1e-3),
        ("augmented-lagrangian", "rk8", 1e-5, 0.0),
        ("augmented-lagrangian", "rk8", 1e-5, 1e-3),
    ],
)
def test_ten_singular_passes(name, integrator, rtol, core, reference):
    """A02 with N = 2: all ten are seen, and the motion stays on its branch.

    Rods with and without inertia about their own axes are eliminated body by body.
    """
    sample = four_bars(2, core=core)
    assert by_blocks(sample.model)
    done = run(sample, name, [0.0, 4.0, 10.0], integrator, rtol)
    assert done.solution.status == "finished", done.solution.message
    place = sample.place(done.solution.y)[:, :2]
    goal = reference["n-2"]
    assert np.linalg.norm(place[1] - goal["at_4"]) < reference["tolerance"]
    assert np.linalg.norm(place[2] - goal["exact"]) < reference["tolerance"]
    assert np.ptp(done.energy) < reference["energy_tolerance"]
    assert not done.monitor.findings
    assert len(done.monitor.passes) == 10
    np.testing.assert_allclose(done.monitor.passes, _passes(2, 10.0), atol=1e-3)
    assert abs(done.monitor.passes[0] - goal["first_pass"]) < 1e-4


@pytest.mark.parametrize("name", ["ggl", "index3"])
def test_generalized_alpha_stays_on_the_branch(name, reference):
    """Second order: the phase at 10 s is off, the branch and the number of passes are not."""
    # rtol = 1e-5 gives 0.029 to 0.032 s, by the last digits of the velocities at the start
    done = run(four_bars(1), name, [0.0, 10.0], rtol=5e-6)
    assert done.solution.status == "finished"
    assert not done.monitor.findings
    exact = _passes(1, 10.0)
    assert len(done.monitor.passes) == exact.size
    np.testing.assert_allclose(done.monitor.passes, exact, atol=0.03)


@pytest.mark.parametrize(("name", "integrator"), [("index1", "rk8"), ("baumgarte", "gear")])
def test_treatments_that_divide_by_zero_end_with_the_cause(name, integrator):
    done = run(four_bars(1), name, [0.0, 10.0], integrator, rtol=1e-7)
    assert (done.solution.status, done.solution.code) == ("stopped", "singular-position")
    assert done.solution.t[-1] == pytest.approx(_passes(1, 1.0)[0], abs=1e-4)
    message = done.solution.message
    assert "loses rank at t = 0.70" in message
    assert all(joint in message for joint in ALL_JOINTS)
    assert '"projection"' in message


MISFIT = 1e-7  # m: the branches turn into each other where the exact mechanism passes


@pytest.mark.provokes("branch-change")
def test_a_turn_onto_another_branch_keeps_the_energy_and_is_seen():
    """Told to warn only, a run follows the misfit round the corner within 20 microseconds."""
    done = run(four_bars(1, MISFIT), "index1", [0.0, 1.5], "rk8", rtol=1e-9, stop=False)
    codes = [finding.code for finding in done.monitor.findings]
    assert codes == ["singular-position", "branch-change"]
    assert np.ptp(done.energy) < 1e-6, "the energy alone would not tell"
    assert "velocity turned by 1." in done.monitor.findings[1].text


def test_a_turn_ends_runs_of_treatments_that_pass_singular_positions():
    """Projection, with accelerations that divide by the vanishing singular value."""
    sample, treatment = four_bars(1, MISFIT), Treatment("projection")
    model, y0 = prepared(sample, treatment)
    exactly = model._replace(penalty=0.0)
    made = new_run(exactly, y0, treatment, "rk8", 1.5, rtol=1e-8, atol=1e-10)
    monitor = SingularityMonitor(model, sample.names, "projection")
    monitor.at_start(0.0, y0)
    solution = integrate(made, [0.0, 1.5], watch=monitor)
    assert (solution.status, solution.code) == ("stopped", "branch-change")
    assert "another branch" in solution.message
    assert "t = 0.708" in solution.message


def test_a_close_approach_is_no_singular_position():
    """With 10 micrometres of misfit the corner is round, and all treatments follow it."""
    places = []
    for name in ("index1", "projection"):
        sample = four_bars(1, 1e-5)
        done = run(sample, name, [0.0, 1.5], "rk8", rtol=1e-9)
        assert done.solution.status == "finished", done.solution.message
        assert not done.monitor.passes
        places.append(sample.place(done.solution.y[-1:])[0])
    assert np.linalg.norm(places[0] - places[1]) < 1e-6


def test_a_failure_in_a_singular_position_is_explained():
    sample = four_bars(1)
    model, y0 = prepared(sample, Treatment("index1"))
    monitor = SingularityMonitor(model, sample.names, "index1")
    monitor.at_start(0.0, y0)
    assert monitor.explain(0.0, y0) == ""

    def until_nearly_flat(t, y):
        if t > 0.708:
            raise np.linalg.LinAlgError("singular matrix")
        return derivative(model, t, y)

    broken = new_integrator("rk8", until_nearly_flat, 0.0, y0, 1.0, rtol=1e-6, atol=1e-8)
    solution = integrate(broken, [0.0, 1.0])
    assert solution.status == "failed"
    words = monitor.explain(float(solution.t[-1]), solution.y[-1])
    assert "loses rank at t = 0.70" in words
    assert "left 0" in words
    monitor.treatment = "ggl"
    assert "increase rtol" in monitor.explain(float(solution.t[-1]), solution.y[-1])


@pytest.mark.parametrize("make", [bricard, lambda: chain(3), lambda: chain(4, "spherical")])
@pytest.mark.parametrize("name", ["baumgarte", "projection"])
def test_no_alarm_where_nothing_is_singular(make, name):
    done = run(make(), name, [0.0, 2.0], rtol=1e-6)
    assert done.solution.status == "finished"
    assert not done.monitor.passes
    assert not done.monitor.findings


def test_forty_loops_pass_their_first_singular_position(reference):
    """Forty singular values vanish at once; 120 of 605 equations are redundant."""
    sample = four_bars(40)
    done = run(sample, "projection", [0.0, 0.75], "rk8", rtol=1e-5)
    assert done.solution.status == "finished", done.solution.message
    assert done.model.redundant == 120
    assert done.monitor.passes == [pytest.approx(reference["n-40"]["first_pass"], abs=1e-5)]
    feet = np.arange(41.0)
    y = done.solution.y[-1]
    middles = np.array([y[7 * i : 7 * i + 3] for i in range(41)]) - feet[:, None] * [1, 0, 0]
    assert np.ptp(middles, axis=0).max() < 1e-9, "uprights are no longer parallel"
