"""Generalized-alpha on constrained systems, and the projection hook of the others."""

import numpy as np
import pytest
from samples.constraint_runs import new_generic, new_run, prepared, run
from samples.mechanism_samples import Sample, bricard, chain, pendulum
from samples.two_body_samples import stretching_rod
from scipy_integrators import SCIPY

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.table import FOR_EQUATIONS
from plymotion.solver.math.laws import polynomial
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, rigid_body

FORMULATIONS = ("ggl", "index3")


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("make", [pendulum, lambda: chain(2, "spherical"), bricard])
def test_observed_order_is_two(make, formulation):
    """Fixed steps against rk8; positions and velocities, of three-dimensional rotations too."""
    sample, t_end = make(), 0.4
    exact = run(sample, "projection", [0.0, t_end], rtol=1e-11).solution.y[-1]
    model, y0 = prepared(sample, Treatment(formulation))
    errors = []
    for n in (40, 80, 160):
        options = {"rtol": 1e-10, "atol": 1e-12, "fixed_step": t_end / n}
        made = new_run(model, y0, Treatment(formulation), "generalized-alpha", t_end, **options)
        y = integrate(made, [0.0, t_end]).y[-1]
        assert made.counters.steps == n
        errors.append(
            [np.abs((y - exact)[: model.n_pos]).max(), np.abs((y - exact)[model.n_pos : -1]).max()]
        )
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(rates, 2.0, atol=0.25)
    assert errors[-1][0] < 2e-3


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_error_follows_the_tolerance(formulation):
    """The error of a second-order method: (tolerance)^(2/3)."""
    exact = run(pendulum(), "projection", [0.0, 2.0], rtol=1e-11).solution.y[-1]
    tolerances, measured = [1e-4, 1e-5, 1e-6], []
    for rtol in tolerances:
        y = run(pendulum(), formulation, [0.0, 2.0], rtol=rtol).solution.y[-1]
        measured.append(np.abs(y - exact)[:3].max())
    slope = np.polyfit(np.log10(tolerances), np.log10(measured), 1)[0]
    assert 0.5 < slope < 0.85
    assert measured[-1] < 2e-3


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_dense_output_is_as_good_as_the_steps(formulation):
    times = np.linspace(0.0, 2.0, 173)
    exact = run(pendulum(), "projection", times, rtol=1e-11).solution.y
    done = run(pendulum(), formulation, times, rtol=1e-6)
    at_steps = run(pendulum(), formulation, [0.0, 2.0], rtol=1e-6)
    assert done.solution.counters.steps == at_steps.solution.counters.steps
    assert np.abs(done.solution.y - exact)[:, :3].max() < 1e-3
    radius = np.linalg.norm(done.solution.y[:, :3], axis=1)
    assert np.abs(radius - 1.0).max() < 1e-6  # the cubic between the steps: rtol


def test_work_of_a_moving_constraint():
    """A mass driven along a line by x = sin t, as a series: the work is its kinetic energy."""
    mass = rigid_body("mass", 2.0, np.zeros(3), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    series = [0.0, 1.0, 0.0, -1.0 / 6.0, 0.0, 1.0 / 120.0, 0.0, -1.0 / 5040.0]
    joints = [
        JointTable("slide", "prismatic", 0, 1),
        JointTable("drive", "translation_drive", 0, 1, polynomial(series)),
    ]
    model = assemble_model([mass], markers, joints)
    positions, none = np.zeros(7), np.zeros(6)
    positions[3] = 1.0
    sample = Sample(model, Start(positions, none, none.astype(bool)), ["slide", "drive"], 1)
    times = np.linspace(0.0, 3.0, 16)
    # the norm is the root of a mean of seven squares, of which one is not zero
    tolerance = 1e-6 / np.sqrt(7.0)
    y = run(sample, "ggl", times, rtol=tolerance, atol=1e-2 * tolerance).solution.y
    place = np.polynomial.Polynomial(series)
    np.testing.assert_allclose(y[:, 2], place(times), atol=1e-6)
    # a quadrature of third order over the steps that the positions ask for
    speed = place.deriv()(times)
    np.testing.assert_allclose(y[:, -1], speed**2 - 1.0, atol=1e-3)


def test_stiff_modes_do_not_limit_the_step():
    """A pendulum on a rod ten thousand times as stiff as its swing: steps follow the swing."""
    options = {"rtol": 1e-5, "atol": 1e-7}
    rigid = run(stretching_rod(None), "projection", [2.0], rtol=1e-8).solution.y[-1]
    done = run(stretching_rod(1e8), "ggl", [0.0, 2.0], **options).solution
    assert done.status == "finished"
    assert np.abs(done.y[-1, :7] - rigid[:7]).max() < 5e-3
    assert done.counters.steps < 2000  # the rod swings 3000 times


def _circle(t, y):
    return np.array([-y[1], y[0]])


@pytest.mark.parametrize("name", sorted(FOR_EQUATIONS | SCIPY))
def test_projection_hook_holds_an_invariant(name):
    """The unit circle: kept by projection at steps and between them, with the same few steps."""

    def project(t, y):
        return y / np.linalg.norm(y)

    options = {"rtol": 1e-5, "atol": 1e-7}
    times = np.linspace(0.0, 30.0, 77)
    free = integrate(new_generic(name, _circle, 0.0, np.array([1.0, 0.0]), 30.0, **options), times)
    made = new_generic(name, _circle, 0.0, np.array([1.0, 0.0]), 30.0, project=project, **options)
    held = integrate(made, times)
    assert np.abs(np.linalg.norm(free.y, axis=1) - 1.0).max() > 1e-6
    assert np.abs(np.linalg.norm(held.y, axis=1) - 1.0).max() < 1e-14
    assert held.counters.steps < 1.1 * free.counters.steps
    exact = np.stack((np.cos(times), np.sin(times)), axis=-1)
    assert np.abs(held.y - exact).max() <= np.abs(free.y - exact).max()


@pytest.mark.parametrize("name", sorted(FOR_EQUATIONS | SCIPY))
def test_the_derivative_is_taken_at_the_projected_state(name):
    """What the next step begins with is f at the state that the projection gave."""
    seen = []

    def f(t, y):
        seen.append((t, y.copy()))
        return _circle(t, y)

    def project(t, y):
        return y / np.linalg.norm(y)

    made = new_generic(
        name, f, 0.0, np.array([1.0, 0.0]), 3.0, project=project, rtol=1e-4, atol=1e-6
    )
    made.step()
    made.step()
    if name in ("rk5", "rk8", "scipy-dop853"):  # others evaluate inside Newton's iteration
        assert any(t == made.t and np.array_equal(y, made.y) for t, y in seen)
    assert np.linalg.norm(made.y) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("name", sorted(FOR_EQUATIONS | SCIPY))
def test_a_projection_that_finds_nothing_shortens_the_step_and_then_fails(name):
    def nothing_near(t, y):
        return None if t > 1.0 else y

    made = new_generic(name, _circle, 0.0, np.array([1.0, 0.0]), 3.0, project=nothing_near)
    done = integrate(made, [0.0, 3.0])
    assert done.status == "failed"
    assert "projected onto the constraints" in done.message
    # codes of others do not take a step back that they have accepted
    assert (0.0 if name.startswith("scipy") else 1.0 - 1e-3) < done.t[-1] <= 1.0
