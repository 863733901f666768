"""Generalized-alpha against its published equations, written out densely, and exact solutions.

Arnold and Bruls (2007), Convergence of the generalized-alpha scheme for constrained mechanical
systems, Multibody System Dynamics 18, 185-202: equations (2) to (4) with the step on the group by
the exponential, as Bruls and Cardona (2010).
"""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.constraint_runs import new_run, prepared
from samples.coordinate_samples import force, run
from samples.flexible_samples import Points, body_of
from samples.mechanism_samples import GROUND, Sample, chain, pendulum
from samples.stability_samples import hand, stepped
from samples.two_body_samples import two_bodies

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import (
    accelerations,
    assemble,
    constraint_rates,
)
from plymotion.solver.dynamics.model.coordinates import moved
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.math.laws import polynomial
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.tables import ForceTable, JointTable, MarkerTable

BUSHING = (40.0, 30.0, 20.0, 3.0, 2.0, 1.0, 10.0, 20.0, 30.0, 1.0, 2.0, 3.0)
SAMPLES = {
    "pendulum": pendulum,
    "chain": lambda: chain(2, "spherical"),
    "flexible": lambda: two_bodies(400.0),
    "stiff": lambda: two_bodies(1e8),
    "driven": lambda: two_bodies(400.0, drive=polynomial([0.0, 0.0, 3.0, -2.0])),
    "bushing": lambda: two_bodies(400.0, forces=[ForceTable("b", "bushing", 0, 4, BUSHING)]),
    "hand": lambda: hand("revolute", gravity=True)[0],
}


def coefficients(rho: float) -> tuple[float, float, float, float]:
    """alpha_m, alpha_f, gamma, beta for the spectral radius rho at infinity, as published."""
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 + alpha_f - alpha_m
    return alpha_m, alpha_f, gamma, 0.25 * (gamma + 0.5) ** 2


def published_steps(model, y0, rho: float, h: float, count: int) -> np.ndarray:
    """States (count, n) of the index-3 scheme, work left out, by Newton's method with differences.

    Unknown are vdot and lambda at the end of a step:
        M vdot + Phi_q' lambda = f,  Phi(q) = 0,
        (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) vdot_1 + alpha_f vdot_0,
        q_1 = q_0 exp(h v_0 + h^2 ((1/2 - beta) a_0 + beta a_1)),
        v_1 = v_0 + h ((1 - gamma) a_0 + gamma a_1).
    """
    alpha_m, alpha_f, gamma, beta = coefficients(rho)
    n_pos, n, n_c = model.n_pos, model.n_vel, model.n_constraint
    y = y0.copy()
    v_d, multipliers = accelerations(model, assemble(model, 0.0, y), y)
    a, rows = v_d.copy(), []
    for step in range(1, count + 1):
        q_0, v_0 = y[:n_pos], y[n_pos:-1]

        def end(x, q_0=q_0, v_0=v_0, v_d_0=v_d, a_0=a):
            a_1 = ((1 - alpha_f) * x[:n] + alpha_f * v_d_0 - alpha_m * a_0) / (1 - alpha_m)
            state = y0.copy()
            state[:n_pos] = moved(model, q_0, h * v_0 + h * h * ((0.5 - beta) * a_0 + beta * a_1))
            state[n_pos:-1] = v_0 + h * ((1 - gamma) * a_0 + gamma * a_1)
            return state, a_1

        def left(x, t=step * h, end=end):
            e = assemble(model, t, end(x)[0])
            balance = (e.M @ x[:n] + e.Phi_q.T @ x[n:] - e.f) / model.inertia_scale
            return np.concatenate([balance, e.Phi / h**2])

        x = np.concatenate([v_d, multipliers])
        J = np.empty((n + n_c, n + n_c))
        here = left(x)
        for j in range(n + n_c):
            d = 1e-6 * max(1.0, abs(x[j]))
            near = x.copy()
            near[j] += d
            J[:, j] = (left(near) - here) / d
        for _ in range(40):
            # surplus rows share their multipliers at least norm
            change = np.linalg.lstsq(J, -left(x), rcond=1e-11)[0]
            x += change
            if np.abs(change[:n]).max() < 1e-11 * max(1.0, np.abs(x[:n]).max()):
                break
        y, a = end(x)
        v_d, multipliers = x[:n], x[n:]
        rows.append(y)
    return np.array(rows)


@pytest.mark.parametrize("rho", [0.8, 0.5, 0.0])
@pytest.mark.parametrize("name", SAMPLES)
def test_fixed_steps_are_those_of_the_published_equations(name, rho):
    treatment = Treatment("index3")
    model, y0 = prepared(SAMPLES[name](), treatment)
    h, count = 0.005, 8
    options = {"spectral_radius": rho, "fixed_step": h, "rtol": 1e-12, "atol": 1e-12}
    made = new_run(model, y0, treatment, "generalized-alpha", count * h, **options)
    found = stepped(made, lambda i: i.y.copy())
    expected = published_steps(model, y0, rho, h, count)
    assert len(found) == count
    np.testing.assert_allclose(found[:, : model.n_pos], expected[:, : model.n_pos], atol=1e-9)
    velocity = slice(model.n_pos, -1)
    np.testing.assert_allclose(found[:, velocity], expected[:, velocity], atol=1e-6)


@pytest.mark.parametrize("rho", [0.8, 0.0])
@pytest.mark.parametrize("name", ["pendulum", "chain", "driven", "bushing"])
def test_ggl_is_index_3_with_both_constraints_met(name, rho):
    """Positions and velocities satisfy their constraints; the motion is that of order 2."""
    treatment = Treatment("ggl")
    model, y0 = prepared(SAMPLES[name](), treatment)
    exact = integrate(new_run(model, y0, Treatment(), "rk8", 0.2, rtol=1e-10, atol=1e-12), [0.2]).y[
        -1
    ]
    errors = []
    for n in (20, 40):
        options = {"spectral_radius": rho, "fixed_step": 0.2 / n, "rtol": 1e-10, "atol": 1e-12}
        made = new_run(model, y0, treatment, "generalized-alpha", 0.2, **options)
        for state in _states(made):
            e = assemble(model, *state)
            assert np.abs(e.Phi).max() < 1e-9
            assert np.abs(constraint_rates(model, e, state[1])).max() < 1e-8
        errors.append(np.abs(made.y - exact)[: model.n_pos].max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def _states(made):
    while made.status == "running":
        made.step()
        yield made.t, made.y.copy()


def oscillator(w: float, start: float) -> Sample:
    """A unit mass on one mode of rate w, its frame welded to the ground."""
    phi, psi = np.zeros((1, 3, 1)), np.zeros((1, 3, 1))
    phi[0, 0, 0] = 1.0
    body = body_of(Points(np.ones(1), np.zeros((1, 3)), phi, psi, np.eye(3)[None]), w * w)
    none = np.zeros((3, 1))
    markers = [MarkerTable(GROUND, np.zeros(3)), MarkerTable(0, np.zeros(3), np.eye(3), none, none)]
    model = assemble_model([body], markers, [JointTable("weld", "fixed", 0, 1)])
    positions, rest = np.zeros(8), np.zeros(7)
    positions[3], positions[7] = 1.0, start
    return Sample(model, Start(positions, rest, np.ones(7, dtype=bool)), ["weld"], 1)


def amplification(rho: float, wh: float) -> np.ndarray:
    """One step for (y, h v, h^2 a) of an oscillator, from the published equations alone.

    Its accelerations are not free: vdot_0 = -w^2 y_0 and vdot_1 = -w^2 y_1.
    """
    alpha_m, alpha_f, gamma, beta = coefficients(rho)
    # unknowns y_1, h v_1, h^2 a_1
    new = [[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1 - alpha_f) * wh**2, 0.0, 1 - alpha_m]]
    old = [[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1 - gamma], [-alpha_f * wh**2, 0.0, -alpha_m]]
    return np.linalg.solve(np.array(new), np.array(old))


@pytest.mark.parametrize("formulation", ["ggl", "index3"])
@pytest.mark.parametrize("wh", [0.1, 1.0, 30.0, 1e4])
@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 1.0])
def test_steps_are_those_of_the_amplification_matrix(rho, wh, formulation):
    h, n = 0.01, 30
    treatment = Treatment(formulation)
    model, y0 = prepared(oscillator(wh / h, 1e-9), treatment)
    options = {"spectral_radius": rho, "fixed_step": h, "rtol": 1e-10, "atol": 1e-30}
    made = new_run(model, y0, treatment, "generalized-alpha", n * h, **options)
    found = stepped(made, lambda i: i.y[7])
    state = 1e-9 * np.array([1.0, 0.0, -(wh**2)])
    A = amplification(rho, wh)
    expected = [(np.linalg.matrix_power(A, k) @ state)[0] for k in range(1, n + 1)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * max(np.abs(expected)))


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 1.0])
def test_spectral_radius_at_infinity(rho):
    """Of the published equations; of the product, what a long run leaves from step to step."""
    radius = np.abs(np.linalg.eigvals(amplification(rho, 1e5))).max()
    # a triple root: its eigenvalues move by the cube root of a perturbation
    assert radius == pytest.approx(rho, abs=2e-3)
    if rho == 0.0:
        return
    treatment = Treatment("ggl")
    h, n = 0.01, 400 if rho > 0.7 else 90
    model, y0 = prepared(oscillator(1e5 / h, 1e-9), treatment)
    options = {"spectral_radius": rho, "fixed_step": h, "rtol": 1e-10, "atol": 1e-300}
    made = new_run(model, y0, treatment, "generalized-alpha", n * h, **options)
    q = np.abs(stepped(made, lambda i: i.y[7]))
    m = n // 2
    # q grows as a square times rho^k: a triple root
    assert (q[-1] / q[-1 - m]) ** (1 / m) == pytest.approx(rho * (n / (n - m)) ** (2 / m), rel=0.02)


def test_a_resolved_oscillation_keeps_its_amplitude():
    treatment = Treatment("ggl")
    model, y0 = prepared(oscillator(1.0, 1.0), treatment)
    made = new_run(model, y0, treatment, "generalized-alpha", 20.0, fixed_step=0.02)
    done = integrate(made, np.linspace(0, 20, 101))
    np.testing.assert_allclose(done.y[:, 7], np.cos(done.t), atol=2e-3)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_what_is_not_resolved_is_damped(rho):
    """The welded hand, h w = 100: nothing is left for rho = 0, rho per step for others."""
    sample, w = hand("fixed", bent=(1e-6,))
    treatment = Treatment("ggl")
    model, y0 = prepared(sample, treatment)
    options = {"spectral_radius": rho, "fixed_step": 100 / w[0], "rtol": 1e-9, "atol": 1e-14}
    made = new_run(model, y0, treatment, "generalized-alpha", 60 * 100 / w[0], **options)
    q = np.abs(stepped(made, lambda i: i.y[7]))
    assert made.status == "finished"
    assert q[-1] < 1e-2 * 1e-6


LINKAGE = [(0.0, 0.0, 0.0), (0.3, 0.0, 0.4), (1.2, 0.0, 0.6), (1.0, 0.0, 0.0)]


def linkage() -> str:
    """A four-bar linkage of bars of 1 kg that falls, with friction in the joints on the ground."""
    text = "gravity = [0.0, 0.0, -9.81]\n[ground]\nO = { position = [0, 0, 0] }\n"
    text += "C = { position = [1, 0, 0] }\n"
    text += '[signals.angle]\nkind = "joint"\njoint = "A"\ncoordinate = "angle"\n'
    ends = np.array(LINKAGE)
    for name, one, two in zip(("crank", "coupler", "rocker"), ends[:-1], ends[1:], strict=True):
        half = (0.5 * (two - one)).tolist()
        places = {"a": tuple(-h for h in half), "b": tuple(half)}
        inertia = 0.1 * float((two - one) @ (two - one))
        text += rigid(name, 1.0, inertia, places, position=tuple((0.5 * (one + two)).tolist()))
    pairs = {"A": ("ground.O", "crank.a"), "B": ("crank.b", "coupler.a")}
    pairs |= {"D": ("coupler.b", "rocker.a"), "E": ("rocker.b", "ground.C")}
    for name, (one, two) in pairs.items():
        ends_of = f'between = ["{one}", "{two}"]\naxis = [0.0, 1.0, 0.0]\n'
        text += f'[joints.{name}]\nkind = "revolute"\n{ends_of}'
    for name in "AE":
        text += force(f"f{name}", "friction", joint=name, coulomb=0.3, rest_velocity=1e-3)
    return text


@pytest.mark.provokes("rtol-not-kept")
def test_errors_are_a_multiple_of_rtol_or_a_finding_says_that_they_are_not(tmp_path):
    """With ggl the error falls as rtol does; with index3 as rtol to the power of 2/3."""
    known = run(tmp_path, linkage(), 1.0, 0.05, 'integrator = "radau"\nrtol = 1e-11')[1]["angle"]
    size, errors = float(np.abs(known).max()), {}
    for treatment in ("ggl", "index3"):
        for rtol in (1e-3, 1e-5):
            solver = f'integrator = "generalized-alpha"\nconstraints = "{treatment}"\nrtol = {rtol}'
            _, found, summary = run(tmp_path, linkage(), 1.0, 0.05, solver)
            codes = {warning["code"] for warning in summary["warnings"]}
            assert ("rtol-not-kept" in codes) == (treatment == "index3")
            errors[treatment, rtol] = float(np.abs(found["angle"] - known).max()) / (size * rtol)
    assert max(errors["ggl", 1e-3], errors["ggl", 1e-5]) < 1.0
    assert errors["ggl", 1e-5] < 2.0 * errors["ggl", 1e-3]
    assert errors["index3", 1e-5] > 3.0 * errors["index3", 1e-3]
