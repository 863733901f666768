"""Force elements: power balance against differences, equal and opposite, and hand-worked values."""

import numpy as np
import pytest
from samples.flexible_samples import body_of, difference, random_marker, random_points, random_state

from plymotion.solver.dynamics.elements.forces.table import FIRST_LOAD, KINDS, N_PARAMETER
from plymotion.solver.dynamics.evaluation.accelerations import assemble, derivative, energies
from plymotion.solver.math import laws
from plymotion.solver.math.rotations import matrix_to_vector, vector_to_matrix
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import ForceTable, MarkerTable, rigid_body

ELASTIC = {
    "spring": (40.0, 0.0, 0.7),
    "rotary_spring": (3.0, 0.0, 0.2),
    "bushing": (40.0, 30.0, 20.0, 3.0, 2.0, 1.0, *[0.0] * 6),
}
LOSSY = {
    "spring": (40.0, 2.0, 0.7),
    "rotary_spring": (3.0, 0.4, 0.2),
    "bushing": (40.0, 30.0, 20.0, 3.0, 2.0, 1.0, 1.0, 2.0, 3.0, 0.1, 0.2, 0.3),
    "force": (1.0, -2.0, 0.5),
    "torque": (1.0, -2.0, 0.5),
}


def _model(kind, parameters, rng, grounded=False):
    points = [random_points(rng, 3), random_points(rng, 2)]
    one = random_marker(rng, -1, 0) if grounded else random_marker(rng, 0, 3)
    two = random_marker(rng, 1, 2)
    law = laws.polynomial([0.4, 1.0]) if kind != "bushing" and parameters[1] else None
    forces = [ForceTable("element", kind, 0, 1, parameters, law)]
    return assemble_model([body_of(p) for p in points], [one, two], [], forces=forces)


def _along(model, y, y_d, s):
    """State after s seconds on a smooth curve with tangent y_d, Euler parameters kept unit."""
    state = y + s * y_d
    for i in range(model.n_body):
        a = model.pos_start[i] + 3
        state[a : a + 4] /= np.linalg.norm(state[a : a + 4])
    return state


@pytest.mark.parametrize("grounded", [False, True])
@pytest.mark.parametrize("kind", list(KINDS))
def test_rate_of_energy_is_the_power(kind, grounded):
    """Total energy changes by the power of dampers, actuators and loads, and by nothing else."""
    rng = np.random.default_rng(5)
    model = _model(kind, LOSSY[kind], rng, grounded)
    y, t = random_state(rng, model), 0.3
    y_d = derivative(model, t, y)

    def energy(s):
        state = _along(model, y, y_d, s)
        return energies(model, assemble(model, t, state), state).sum()

    power = assemble(model, t, y).power[0]
    assert abs(power) > 1e-3
    assert difference(energy) == pytest.approx(power, rel=1e-8)
    assert y_d[-1] == pytest.approx(power)


@pytest.mark.parametrize("kind", list(ELASTIC))
def test_springs_alone_do_no_work(kind):
    rng = np.random.default_rng(6)
    model = _model(kind, ELASTIC[kind], rng)
    assert assemble(model, 0.0, random_state(rng, model)).power[0] == 0.0


@pytest.mark.parametrize("kind", list(ELASTIC))
def test_elements_between_bodies_push_back(kind):
    """Forces and moments between two free bodies add up to nothing, about any point."""
    rng = np.random.default_rng(8)
    bodies = [rigid_body("a", 1.0, np.zeros(3), np.eye(3)) for _ in range(2)]
    markers = [MarkerTable(k, rng.normal(size=3)) for k in range(2)]
    forces = [ForceTable("element", kind, 0, 1, LOSSY[kind])]
    model = assemble_model(bodies, markers, [], forces=forces)
    y = random_state(rng, model)
    with_element = assemble(model, 0.0, y).f
    without = assemble(assemble_model(bodies, markers, []), 0.0, y).f
    total, about_origin = np.zeros(3), np.zeros(3)
    for i in range(2):
        a, j = model.pos_start[i], model.vel_start[i]
        pushed = (with_element - without)[j : j + 6]
        p = y[a + 3 : a + 7]
        A = vector_to_matrix(2 * np.arctan2(np.linalg.norm(p[1:]), p[0]) * _unit(p[1:]))
        total += pushed[:3]
        about_origin += np.cross(y[a : a + 3], pushed[:3]) + A @ pushed[3:]
    assert np.abs(with_element - without).max() > 0.1
    assert np.abs(total).max() < 1e-12
    assert np.abs(about_origin).max() < 1e-12


def _unit(v):
    return v / np.linalg.norm(v)


def test_following_and_fixed_loads():
    """A force of 2 N along y: fixed on the ground's axes, turning with the body's."""
    body = rigid_body("a", 1.0, np.zeros(3), np.eye(3))
    markers = [
        MarkerTable(-1, np.zeros(3)),
        MarkerTable(0, np.array([0.5, 0.0, 0.0])),
        MarkerTable(0, np.array([0.5, 0.0, 0.0])),
    ]
    law = laws.polynomial([2.0])
    y = np.zeros(14)
    y[3], y[6] = np.sqrt(0.5), np.sqrt(0.5)  # a quarter turn about z
    direction = (0.0, 1.0, 0.0)
    for reference, expected in ((0, [0.0, 2.0, 0.0]), (2, [-2.0, 0.0, 0.0])):
        forces = [ForceTable("load", "force", reference, 1, direction, law)]
        f = assemble(assemble_model([body], markers, [], forces=forces), 0.0, y).f
        assert f[:3] == pytest.approx(np.array(expected), abs=1e-12)
    # the following force acts along the body's y at x = 0.5: moment 1 N m about z
    assert f[3:6] == pytest.approx(np.array([0.0, 0.0, 1.0]))


def test_rotary_spring_passes_half_a_turn_from_its_rest_only():
    body = rigid_body("a", 1.0, np.zeros(3), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    forces = [ForceTable("spring", "rotary_spring", 0, 1, (3.0, 0.0, np.radians(170.0)))]
    model = assemble_model([body], markers, [], forces=forces)
    y = np.zeros(14)
    angle = np.radians(-170.0)  # 20 deg beyond the rest
    y[3], y[6] = np.cos(angle / 2), np.sin(angle / 2)
    assert assemble(model, 0.0, y).f[5] == pytest.approx(-3.0 * np.radians(20.0))


def test_rotation_vector_inverts_the_exponential():
    rng = np.random.default_rng(3)
    for size in (0.0, 1e-9, 1e-4, 1.0, 3.1):
        theta = size * _unit(rng.normal(size=3))
        assert matrix_to_vector(vector_to_matrix(theta)) == pytest.approx(theta, abs=1e-12)


def test_every_kind_fits_the_table():
    assert set(LOSSY) == set(KINDS)
    assert max(len(p) for p in LOSSY.values()) == N_PARAMETER
    assert set(ELASTIC) == {k for k, number in KINDS.items() if number < FIRST_LOAD}
