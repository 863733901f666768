"""Generalized-alpha on constrained systems, and the projection hook of the others."""

import numpy as np
import pytest
from constraint_runs import new_run, prepared, run
from mechanism_samples import bricard, chain, pendulum

from plymotion.solver.dynamics.constraints.treatment import Treatment
from plymotion.solver.integrators.generic import (
    INTEGRATORS,
    ConstrainedSystem,
    integrate,
    new_constrained_integrator,
    new_integrator,
)

FORMULATIONS = ("ggl", "index3")


class Terms:
    """Equations at one state, for systems written out by hand."""

    def __init__(self, M, f, Phi_q, Phi, Phi_t=None, power=0.0):
        self.M, self.f, self.Phi_q, self.Phi = M, f, Phi_q, Phi
        self.Phi_t = np.zeros(Phi.size) if Phi_t is None else Phi_t
        self.power = np.array([power])


def _system(terms, n, gamma):
    """A system whose velocities are the rates of its n positions; gamma(t, y) as in Eq. (11)."""

    def accelerations(t, y):
        e = terms(t, y)
        n_c = e.Phi.size
        A = np.block([[e.M, e.Phi_q.T], [e.Phi_q, np.zeros((n_c, n_c))]])
        x = np.linalg.solve(A, np.concatenate([e.f, gamma(t, y)]))
        return x[:n], x[n:]

    def derivative(t, y):
        e = terms(t, y)
        a, multipliers = accelerations(t, y)
        return np.concatenate([y[n : 2 * n], a, [multipliers @ e.Phi_t + e.power[0]]])

    return ConstrainedSystem(
        n_pos=n,
        n_vel=n,
        inertia_scale=np.ones(n),
        terms=terms,
        accelerations=accelerations,
        derivative=derivative,
        rates=lambda q, v: v,
        move=lambda q, step: q + step,
    )


def oscillator(w):
    """w^2 as stiffness of a unit mass, without constraints."""

    def terms(t, y):
        return Terms(np.eye(1), -w * w * y[:1], np.zeros((0, 1)), np.zeros(0))

    return _system(terms, 1, lambda t, y: np.zeros(0))


def plane_pendulum():
    """A unit mass on a massless rod of 1 m in the plane, g = 9.81."""

    def terms(t, y):
        x = y[:2]
        return Terms(
            np.eye(2), np.array([0.0, -9.81]), x[None, :].copy(), np.array([0.5 * (x @ x - 1.0)])
        )

    return _system(terms, 2, lambda t, y: np.array([-(y[2:4] @ y[2:4])]))


def _new(system, y0, t_end, **options):
    return new_constrained_integrator(
        "generalized-alpha", system, 0.0, np.array(y0, dtype=float), t_end, **options
    )


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
        made = new_run(model, y0, Treatment(formulation), "", t_end, **options)
        y = integrate(made, [0.0, t_end]).y[-1]
        assert made.counters.steps == n
        errors.append(
            [
                np.abs((y - exact)[: model.n_pos]).max(),
                np.abs((y - exact)[model.n_pos : -1]).max(),
            ]
        )
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(rates, 2.0, atol=0.25)
    assert errors[-1][0] < 2e-3


def _amplification(rho, wh):
    """One step for (y, h v, h^2 a) of an oscillator, from the formulas of the class alone.

    Its accelerations are not free: vdot_0 = -w^2 y_0 and vdot_1 = -w^2 y_1.
    """
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    # unknowns y_1, h v_1, h^2 a_1
    new = [
        [1.0, 0.0, -beta],
        [0.0, 1.0, -gamma],
        [(1 - alpha_f) * wh**2, 0.0, 1 - alpha_m],
    ]
    old = [[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1 - gamma], [-alpha_f * wh**2, 0.0, -alpha_m]]
    return np.linalg.solve(np.array(new), np.array(old))


@pytest.mark.parametrize("wh", [0.1, 1.0, 30.0, 1e4])
@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 1.0])
def test_steps_are_those_of_the_amplification_matrix(rho, wh):
    h, n = 0.01, 30
    options = {"spectral_radius": rho, "fixed_step": h, "rtol": 1e-10, "atol": 1e-30}
    made = _new(oscillator(wh / h), [1e-9, 0.0, 0.0], n * h, **options)
    found = []
    integrate(made, [n * h], lambda i: found.append(i.y[0]) or None)
    state = 1e-9 * np.array([1.0, 0.0, -(wh**2)])
    A = _amplification(rho, wh)
    expected = [(np.linalg.matrix_power(A, k) @ state)[0] for k in range(1, n + 1)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * max(np.abs(expected)))


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 1.0])
def test_spectral_radius_at_infinity(rho):
    radius = np.abs(np.linalg.eigvals(_amplification(rho, 1e5))).max()
    # a triple root: its eigenvalues move by the cube root of a perturbation
    assert radius == pytest.approx(rho, abs=2e-3)


def test_a_resolved_oscillation_keeps_its_amplitude():
    done = integrate(
        _new(oscillator(1.0), [1.0, 0.0, 0.0], 20.0, fixed_step=0.02), np.linspace(0, 20, 101)
    )
    np.testing.assert_allclose(done.y[:, 0], np.cos(done.t), atol=2e-3)


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
    """A mass driven along a line by x = sin t: the work is its kinetic energy."""

    def terms(t, y):
        return Terms(
            2.0 * np.eye(1),
            np.zeros(1),
            np.ones((1, 1)),
            np.array([y[0] - np.sin(t)]),
            np.array([-np.cos(t)]),
        )

    system = _system(terms, 1, lambda t, y: np.array([-np.sin(t)]))
    times = np.linspace(0.0, 3.0, 16)
    done = integrate(_new(system, [0.0, 1.0, 0.0], 3.0, rtol=1e-6, atol=1e-8), times)
    # the norm is the root of a mean of three squares
    np.testing.assert_allclose(done.y[:, 0], np.sin(times), atol=np.sqrt(3) * 1e-6)
    # a quadrature of third order over the steps that the positions ask for: 6e-4 measured
    np.testing.assert_allclose(done.y[:, 2], np.cos(times) ** 2 - 1.0, atol=1e-3)


@pytest.mark.xfail(reason="after a shorter step the rod's own swing is resolved: 15 000 steps")
def test_stiff_modes_do_not_limit_the_step():
    """A pendulum on a rod ten thousand times as stiff as its swing: steps follow the swing."""

    def terms(t, y):
        x = y[:2]
        length = np.linalg.norm(x)
        pull = -1e8 * (length - 1.0) * x / length
        return Terms(np.eye(2), pull + np.array([0.0, -9.81]), np.zeros((0, 2)), np.zeros(0))

    system = _system(terms, 2, lambda t, y: np.zeros(0))
    made = _new(system, [1.0, 0.0, 0.0, 0.0, 0.0], 2.0, rtol=1e-5, atol=1e-7)
    done = integrate(made, [0.0, 2.0])
    assert done.status == "finished"
    rigid = integrate(
        _new(plane_pendulum(), [1.0, 0.0, 0.0, 0.0, 0.0], 2.0, rtol=1e-8, atol=1e-10), [2.0]
    )
    assert np.abs(done.y[-1, :2] - rigid.y[-1, :2]).max() < 5e-3
    assert done.counters.steps < 2000  # the rod swings 3000 times


def _circle(t, y):
    return np.array([-y[1], y[0]])


@pytest.mark.parametrize("name", sorted(INTEGRATORS))
def test_projection_hook_holds_an_invariant(name):
    """The unit circle: kept by projection at steps and between them, with the same few steps."""

    def project(t, y):
        return y / np.linalg.norm(y)

    options = {"rtol": 1e-5, "atol": 1e-7}
    times = np.linspace(0.0, 30.0, 77)
    free = integrate(
        new_integrator(name, _circle, 0.0, np.array([1.0, 0.0]), 30.0, **options), times
    )
    made = new_integrator(
        name, _circle, 0.0, np.array([1.0, 0.0]), 30.0, project=project, **options
    )
    held = integrate(made, times)
    assert np.abs(np.linalg.norm(free.y, axis=1) - 1.0).max() > 1e-6
    assert np.abs(np.linalg.norm(held.y, axis=1) - 1.0).max() < 1e-14
    assert held.counters.steps < 1.1 * free.counters.steps
    exact = np.stack((np.cos(times), np.sin(times)), axis=-1)
    assert np.abs(held.y - exact).max() <= np.abs(free.y - exact).max()


@pytest.mark.parametrize("name", sorted(INTEGRATORS))
def test_the_derivative_is_taken_at_the_projected_state(name):
    """What the next step begins with is f at the state that the projection gave."""
    seen = []

    def f(t, y):
        seen.append((t, y.copy()))
        return _circle(t, y)

    def project(t, y):
        return y / np.linalg.norm(y)

    made = new_integrator(
        name, f, 0.0, np.array([1.0, 0.0]), 3.0, project=project, rtol=1e-4, atol=1e-6
    )
    made.step()
    made.step()
    if name in ("rk5", "rk8", "scipy-dop853"):  # others evaluate inside Newton's iteration
        assert any(t == made.t and np.array_equal(y, made.y) for t, y in seen)
    assert np.linalg.norm(made.y) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("name", sorted(INTEGRATORS))
def test_a_projection_that_finds_nothing_shortens_the_step_and_then_fails(name):
    def nothing_near(t, y):
        return None if t > 1.0 else y

    made = new_integrator(name, _circle, 0.0, np.array([1.0, 0.0]), 3.0, project=nothing_near)
    done = integrate(made, [0.0, 3.0])
    assert done.status == "failed"
    assert "projected onto the constraints" in done.message
    # codes of others do not take a step back that they have accepted
    assert (0.0 if name.startswith("scipy") else 1.0 - 1e-3) < done.t[-1] <= 1.0
