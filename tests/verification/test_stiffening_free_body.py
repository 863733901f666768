"""Stiffened bodies in free flight and in a bent state: what a right form of the terms must keep.

Energy tells a right form from one that stiffens the elastic rows only; a spin-up does not.
"""

import numpy as np
import pytest
from samples.beam_samples import (
    CHORD,
    CLAMPED,
    MEAN_AXIS,
    NAMES,
    REFERENCES,
    coupled_stiffness,
    reduced,
    without_pieces,
)
from samples.curved_samples import meshed
from samples.flexible_samples import momenta, total_energy
from samples.stiffening_samples import on_interface

from plymotion.preprocess.beam.beam_body import held_dofs
from plymotion.preprocess.beam.beam_stations import mass_stations, point_masses
from plymotion.preprocess.beam.line import SectionMass
from plymotion.preprocess.beam.mode_fields import second_order_fields
from plymotion.solver.dynamics.analysis.recovery import momentum_balance
from plymotion.solver.dynamics.elements.floating_frame import stiffening_matrices
from plymotion.solver.dynamics.elements.marker import marker_motion
from plymotion.solver.dynamics.evaluation.accelerations import (
    accelerations,
    assemble,
    constraint_rates,
    derivative,
    energies,
)
from plymotion.solver.math.rotations import matrix_to_parameters, rotation_matrix
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, flexible_body, rigid_body

GRAVITY = (0.3, -9.81, 2.0)


# A section rolled in the body, with a product of inertia beside an offset mass centre.
UNSYMMETRIC = {
    "mass": SectionMass(
        1.0,
        np.array([0.0, 0.02, -0.01]),
        np.array([[0.03, 0.0, 0.0], [0.0, 0.018, 0.004], [0.0, 0.004, 0.012]]),
    ).matrix(),
    "x2_axis": [0.0, 0.8, 0.6],
}
FORMS = {
    "alone": {},
    "with a mass at the tip": {"carried": True},
    "lumped": {"mass_form": "lumped"},
    "unsymmetric": UNSYMMETRIC,
    "bulky lumps": {  # inertia along the beam, too: six points for a node
        "mass": SectionMass(1.0, np.zeros(3), np.diag([0.03, 0.025, 0.02])).matrix(),
        "mass_form": "lumped",
    },
    "curved and twisted": {
        **UNSYMMETRIC,
        **meshed(4, length=1.0, line={"arc_deg": 60.0}, twist_deg=[[0.0, 10.0], [1.0, 70.0]]),
    },
}


def flying(reference, *, carried=False, gravity=(0.0, 0.0, 0.0), stiffening=True, **changes):
    """A coupled beam that tumbles about all axes, bends in both planes and twists."""
    modes = [{"kind": "lowest", "count": 5}]
    beam = reduced(reference, modes, K=coupled_stiffness(), **changes)
    body = flexible_body("beam", beam.package, stiffening=stiffening)
    marker = on_interface(0, beam, "tip", stiffening=stiffening)
    masses = [(0, 0.5)] if carried else []
    model = assemble_model([body], [marker], [], masses, gravity)
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3] = 1.0
    y[12:18] = [1.0, -0.4, 0.7, 3.0, 6.0, -4.0]
    y[18:23] = 0.3 * np.random.default_rng(2).normal(size=5)
    return beam, model, y


def classical(model, y, step, end):
    """Runge's and Kutta's method with fixed steps: states at the ends of all steps."""
    states = [y]
    for k in range(round(end / step)):
        t, y = k * step, states[-1]
        a = derivative(model, t, y)
        b = derivative(model, t, y + 0.5 * step * a)
        c = derivative(model, t, y + 0.5 * step * b)
        d = derivative(model, t, y + step * c)
        states.append(y + step / 6.0 * (a + 2.0 * b + 2.0 * c + d))
    return states


def drift(model, states):
    """Largest departures of energy and of both momenta, over their first values."""
    energy = np.array([total_energy(model, y) for y in states])
    linear, angular = (np.array(p) for p in zip(*(momenta(model, y) for y in states), strict=True))
    return [
        np.abs(energy / energy[0] - 1.0).max(),
        *(np.abs(p - p[0]).max() / np.linalg.norm(p[0]) for p in (linear, angular)),
    ]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_tumbling_body_keeps_energy_and_both_momenta(reference, form):
    """The drift is that of the integrator: it falls with the fourth power of the step or faster."""
    _, model, y = flying(reference, **FORMS[form])
    coarse, fine = (drift(model, classical(model, y, h, 0.06)) for h in (1e-3, 5e-4))
    for one, two in zip(coarse, fine, strict=True):
        assert two < 1e-13 or (two < 1e-6 and one / two > 12.0)


def test_stiffening_in_the_elastic_rows_only_loses_energy():
    """The naive form: halving the step does not help, though the momenta look sound."""
    _, model, y = flying(CHORD)
    _, linear, _ = flying(CHORD, stiffening=False)

    def naive(step):
        states = [y]

        def rate(t, state):
            equations = assemble(linear, t, state)
            v_d, _ = accelerations(linear, equations, state)
            f = equations.f.copy()
            pull = rotation_matrix(state[3:7]).T @ v_d[:3]
            held = (state[15:18], v_d[3:6], pull, np.zeros(5))
            Kg = stiffening_matrices(model, 0, *(part[None] for part in held))[0]
            f[6:] -= Kg @ state[7:12]
            out = derivative(linear, t, state)
            out[12:23] = np.linalg.solve(equations.M, f)
            return out

        for _ in range(round(0.06 / step)):
            s = states[-1]
            a = rate(0.0, s)
            b = rate(0.0, s + 0.5 * step * a)
            c = rate(0.0, s + 0.5 * step * b)
            d = rate(0.0, s + step * c)
            states.append(s + step / 6.0 * (a + 2.0 * b + 2.0 * c + d))
        return drift(linear, states)

    coarse, fine = naive(1e-3), naive(5e-4)
    assert fine[0] > 1e-3
    assert coarse[0] / fine[0] < 1.1
    assert max(fine[1:]) < 1e-7


@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_mass_matrix_stays_positive_in_bodies_bent_by_loads(reference):
    """Forces and moments at both ends and the middle; a clamped frame allows less than others."""
    turn = 0.05 if reference is CLAMPED else 0.2
    beam, model, y = flying(reference)
    rest = np.linalg.eigvalsh(assemble(model, 0.0, y).M)[0]
    places = [beam.interface(name) for name in ("root", "mid", "tip")]
    shapes = np.vstack([part for i in places for part in (i.phi_B, i.psi_B)])
    for load in np.random.default_rng(4).normal(size=(40, 18)):
        q = np.linalg.solve(beam.package.stiffness, shapes.T @ load)
        y[7:12] = turn / max(np.linalg.norm(i.psi_B @ q) for i in places) * q
        M = assemble(model, 0.0, y).M
        np.testing.assert_allclose(M, M.T, atol=1e-14 * np.abs(M).max())
        assert np.linalg.eigvalsh(M)[0] > 0.7 * rest


@pytest.mark.parametrize("reference", [CHORD, MEAN_AXIS], ids=["chord", "mean-axis"])
def test_mass_matrix_stays_positive_in_bodies_bent_in_any_shape(reference):
    beam, model, y = flying(reference)
    rest = np.linalg.eigvalsh(assemble(model, 0.0, y).M)[0]
    for direction in np.random.default_rng(4).normal(size=(40, 5)):
        q = direction / np.sqrt(np.diag(beam.package.stiffness))
        turn = np.einsum("mna,m->na", beam.package.shapes_B[..., 3:], q)
        y[7:12] = 0.2 / np.linalg.norm(turn, axis=1).max() * q
        assert np.linalg.eigvalsh(assemble(model, 0.0, y).M)[0] > 0.9 * rest


def mass_by_points(beam, q):
    """Mass matrix of frame and modes, summed over all point masses with their whole motion."""
    line, columns = beam.model.line, beam.modes.columns_B
    spec = beam.model.spec
    points = point_masses(mass_stations(line, columns, spec.mass_form))
    held = held_dofs(spec.reference.kind, beam.model.reference_nodes)
    h = second_order_fields(line, columns, points, spec.mass_form, held).h_B
    b = points.x_B + points.phi_B @ q + 0.5 * (h @ q) @ q
    unit = np.tile(np.eye(3), (len(b), 1, 1))
    turn = np.cross(np.eye(3), b[:, None]).swapaxes(1, 2)
    J = np.concatenate([unit, turn, points.phi_B + h @ q], axis=2)
    return np.einsum("k,kai,kaj->ij", points.m, J, J, optimize=True)


@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_mass_matrix_of_a_much_bent_body_is_that_of_all_its_points(reference):
    """A thin blade bent by a quarter of a radian: its twist moves it sideways, as a turn does.

    Without the products of deflection and second-order displacement the mass of their difference
    is much below zero. With twelve pieces of the blade the matrix is within 4 % of a unit diagonal.
    """
    modes = [{"kind": "lowest", "count": 4}, {"kind": "attachment", "at": "tip"}]
    thin = {"mass": SectionMass(1.0, np.zeros(3), np.diag([2e-5, 1e-5, 1e-5])).matrix()}
    beam = reduced(reference, modes, K=coupled_stiffness(), length=1.0, elements=24, **thin)
    tip = beam.interface("tip")
    q = np.linalg.solve(beam.package.stiffness, tip.phi_B.T @ [0.0, 0.3, 1.0])
    if reference is CHORD:  # its ends do not move
        q = np.linalg.solve(beam.package.stiffness, tip.psi_B.T @ [0.0, 1.0, 0.3])
    q *= 0.25 / np.linalg.norm(tip.psi_B @ q)
    whole = mass_by_points(beam, q)
    size = np.sqrt(np.diag(whole))

    def model(package):
        found = assemble_model([flexible_body("beam", package, stiffening=True)], [], [])
        y = np.zeros(found.n_pos + found.n_vel + 1)
        y[3], y[7 : 7 + len(q)] = 1.0, q
        return assemble(found, 0.0, y).M

    found = model(beam.package) / np.outer(size, size)
    whole /= np.outer(size, size)
    without = model(without_pieces(beam.package)) / np.outer(size, size)
    # A clamped frame, of the largest deflection, lacks what the inertia has of third order.
    assert np.linalg.eigvalsh(found)[0] > (-0.02 if reference is CLAMPED else 0.0)
    assert np.linalg.eigvalsh(without)[0] < -0.1
    assert np.abs(found - whole).max() < 0.04
    assert np.abs(without - whole).max() > 0.5


@pytest.mark.parametrize("carried", [False, True])
def test_equations_are_those_of_the_kinetic_energy(carried):
    """Lagrange's equations of the modes and of the frame by differences of T and of the weight."""
    _, model, y = flying(CHORD, carried=carried, gravity=GRAVITY)
    y[7:12] = 0.01 * np.random.default_rng(5).normal(size=5)
    rate = derivative(model, 0.0, y)
    q_dd = rate[12:23]
    # d/dt (dT/dq_d) - d(T - V)/dq = 0, along the flow
    h = 1e-5

    def momentum(state):
        equations = assemble(model, 0.0, state)
        return (equations.M @ state[12:23])[6:]

    change = (momentum(y + h * rate) - momentum(y - h * rate)) / (2 * h)
    slope = np.zeros(5)
    for i in range(5):
        values = []
        for sign in (1.0, -1.0):
            state = y.copy()
            state[7 + i] += sign * h
            kinetic = 0.5 * state[12:23] @ assemble(model, 0.0, state).M @ state[12:23]
            values.append(kinetic - (total_energy(model, state) - kinetic))
        slope[i] = (values[0] - values[1]) / (2 * h)
    np.testing.assert_allclose(change, slope, atol=2e-7 * np.abs(slope).max())
    assert np.abs(q_dd).max() > 1.0


def test_momentum_balance_with_weight_and_a_carried_mass():
    """Weights, with the second-order first moment, balance the rates of both momenta."""
    _, model, y = flying(MEAN_AXIS, carried=True, gravity=GRAVITY)
    y[7:12] = 0.01 * np.random.default_rng(6).normal(size=5)
    balance = momentum_balance(model, np.zeros(1), y[None])
    assert max(balance.linear, balance.angular) < 1e-9


@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_point_mass_equals_a_rigid_body_fixed_to_the_interface(reference):
    """Of terms of all orders: the same accelerations, energies and momenta of a much bent body."""
    beam, merged, y = flying(reference, carried=True, gravity=GRAVITY)
    y[7:12] = 0.02 * np.random.default_rng(7).normal(size=5)
    body = flexible_body("beam", beam.package, stiffening=True)
    mass = rigid_body("mass", 0.5, np.zeros(3), np.zeros((3, 3)))
    markers = [on_interface(0, beam, "tip"), MarkerTable(1, np.zeros(3))]
    joints = [JointTable("fixed", "fixed", 0, 1)]
    apart = assemble_model([body, mass], markers, joints, [], GRAVITY, alpha=0.0, beta=0.0)
    tip = marker_motion(merged, 0, y)
    turning = tip.A.T @ tip.w
    state = np.zeros(apart.n_pos + apart.n_vel + 1)
    state[:12], state[12:15], state[15:19] = y[:12], tip.x, matrix_to_parameters(tip.A)
    state[19:30], state[30:33], state[33:36] = y[12:23], tip.v, turning
    together = assemble(apart, 0.0, state)
    assert np.abs(together.Phi).max() < 1e-13
    assert np.abs(constraint_rates(apart, together, state)).max() < 1e-13

    expected = derivative(merged, 0.0, y)[12:23]
    found = derivative(apart, 0.0, state)[19:30]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(
        energies(apart, together, state), energies(merged, assemble(merged, 0.0, y), y), rtol=1e-12
    )
    for whole, parts in zip(momenta(merged, y), momenta(apart, state), strict=True):
        np.testing.assert_allclose(parts, whole, rtol=0.0, atol=1e-12 * np.linalg.norm(whole))


def test_a_mass_heavier_than_the_body_leaves_its_mass_matrix_positive():
    beam, _, y = flying(CHORD)
    body = flexible_body("beam", beam.package, stiffening=True)
    marker = on_interface(0, beam, "tip")
    model = assemble_model([body], [marker], [], [(0, 20.0 * body.invariants.mass)])
    for direction in np.random.default_rng(8).normal(size=(40, 5)):
        q = direction / np.sqrt(np.diag(beam.package.stiffness))
        turn = np.einsum("mna,m->na", beam.package.shapes_B[..., 3:], q)
        y[7:12] = 0.2 / np.linalg.norm(turn, axis=1).max() * q
        assert np.linalg.eigvalsh(assemble(model, 0.0, y).M)[0] > 0.0
