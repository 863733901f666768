"""Body-by-body elimination against dense linear algebra of the same matrices."""

from dataclasses import replace

import numpy as np
import pytest
from samples.flexible_samples import (
    body_of,
    random_marker,
    random_mechanism,
    random_points,
    random_state,
)
from scipy.linalg import eigh

from plymotion.solver.dynamics.evaluation.accelerations import (
    dense,
    dense_derivative_into,
    derivative_into,
)
from plymotion.solver.dynamics.evaluation.elimination import factorise, solve
from plymotion.solver.dynamics.evaluation.evaluation import evaluate
from plymotion.solver.dynamics.model.model import Model, new_factors, new_workspace
from plymotion.solver.math.laws import polynomial
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import JointTable, MarkerTable


def blocks(model: Model, whole: np.ndarray) -> np.ndarray:
    """A vector (n_vel,) as rows (nb, n) of the bodies; what is beyond a body's size is not read."""
    out = np.full((model.n_body, model.layout.widest), 1e30, dtype=whole.dtype)
    for i, (start, n) in enumerate(zip(model.vel_start, model.layout.size, strict=True)):
        out[i, :n] = whole[start : start + n]
    return out


def whole(model: Model, rows: np.ndarray) -> np.ndarray:
    return np.concatenate([row[:n] for row, n in zip(rows, model.layout.size, strict=True)])


@pytest.mark.parametrize("loops", [0, 2])
@pytest.mark.parametrize("soft", [False, True])
@pytest.mark.parametrize("one", [1.0, 1.0 + 0.0j])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_solution_of_the_saddle_point(seed, one, soft, loops):
    """[K Phi'; Phi -softness] with K = s^2 M + s D + K_e of each body, s real or complex."""
    model = random_mechanism(seed, loops)
    rng = np.random.default_rng(100 + seed)
    work = new_workspace(model)
    evaluate(model, work, 0.0, random_state(rng, model))
    equations = dense(model, work)
    n, n_c = model.n_vel, model.n_constraint
    s = 3.0 if one == 1.0 else 3.0 + 7.0j
    K = s**2 * equations.M + np.diag(rng.uniform(0.0, 5.0, n)) * (1.0 + 0.2 * s)
    softness = rng.uniform(0.01, 0.1, n_c) * s**-2 if soft else np.zeros(n_c) * one
    factors = new_factors(model, model.layout.mass, one)
    for i, (start, m) in enumerate(zip(model.vel_start, model.layout.size, strict=True)):
        block = K[start : start + m, start : start + m]
        factors.L[i] = np.nan  # only the lower triangle is read
        factors.L[i][np.tril_indices(m)] = block[np.tril_indices(m)]
    factorise(model.layout, model.layout.mass, factors, work.J, softness)
    f, gamma = rng.normal(size=n) * one, rng.normal(size=n_c) * one
    if one != 1.0:
        f, gamma = f + 1j * rng.normal(size=n), gamma + 1j * rng.normal(size=n_c)
    A = np.zeros((n + n_c, n + n_c)) * one
    A[:n, :n], A[:n, n:], A[n:, :n] = K, equations.Phi_q.T, equations.Phi_q
    A[range(n, n + n_c), range(n, n + n_c)] = -softness
    expected = np.linalg.solve(A, np.concatenate([f, gamma]))
    a, multipliers = np.zeros_like(work.load) * one, np.zeros(n_c) * one
    for _ in range(2):  # factors serve any number of right-hand sides
        solve(model.layout, model.layout.mass, factors, blocks(model, f), gamma, a, multipliers)
        found = np.concatenate([whole(model, a), multipliers])
        scale = np.linalg.norm(expected)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10 * scale)


def test_least_pivot_tells_rows_that_depend_on_others():
    """Two joints at the same two markers: the rows of the second follow from the first."""
    rng = np.random.default_rng(4)
    bodies = [body_of(random_points(rng, 2)), body_of(random_points(rng, 0))]
    markers = [random_marker(rng, 0, 2), random_marker(rng, 1, 0)]
    regular = {}
    for name, joints in (("once", ["spherical"]), ("twice", ["spherical", "revolute"])):
        tables = [JointTable(kind, kind, 0, 1) for kind in joints]
        model = assemble_model(bodies, markers, tables)
        work = new_workspace(model)
        evaluate(model, work, 0.0, random_state(rng, model))
        for i in range(2):
            work.factors.L[i] = work.M[i]
        factorise(model.layout, model.layout.mass, work.factors, work.J, work.softness)
        regular[name] = float(work.factors.regular[0])
    assert regular["once"] > 1e-4
    assert regular["twice"] < 1e-12


MOUNTS = {
    "wall": [("fixed", None)],
    "hub": [("revolute", None), ("rotation_drive", polynomial([0.1, 2.0, 0.3]))],
    "slide": [("translation_drive", polynomial([0.0, 1.0])), ("prismatic", None)],
    "screw": [
        ("rotation_drive", polynomial([0.2, 1.0])),
        ("cylindrical", None),
        ("translation_drive", polynomial([0.0, 0.5])),
    ],
}


@pytest.mark.parametrize("uncoupled", [False, True])
@pytest.mark.parametrize("mount", MOUNTS)
def test_driven_frames_are_no_unknowns(mount, uncoupled):
    """A blade on a mount with a pendulum at its tip: the same answers as with six more rows."""
    rng = np.random.default_rng(6)
    blade, arm = (_sample(rng, m, uncoupled=uncoupled) for m in (3, 2))
    ground = MarkerTable(-1, np.zeros(3))
    foot = MarkerTable(0, rng.normal(size=3), np.eye(3), np.zeros((3, 3)), np.zeros((3, 3)))
    markers = [ground, foot, random_marker(rng, 0, 3), random_marker(rng, 1, 2)]
    joints = [JointTable(kind, kind, 0, 1, law) for kind, law in MOUNTS[mount]]
    joints.insert(1, JointTable("tip", "spherical", 2, 3))
    model = assemble_model([blade, arm], markers, joints, gravity_G=(0.0, 0.0, -9.81))
    plan = model.layout
    assert list(plan.base) == [6, 0]
    assert plan.mass.first.size == 3  # rows of the tip's joint alone are left
    assert list(plan.lead) == ([6, 6] if uncoupled else [9, 8])
    y = random_state(rng, model)
    one, two = np.empty(y.size), np.empty(y.size)
    work = new_workspace(model)
    derivative_into(model, work, 0.3, y, one)
    dense_derivative_into(model, work, 0.3, y, two)
    np.testing.assert_allclose(one, two, rtol=0.0, atol=1e-10 * np.abs(two).max())


def _sample(rng, n_mode, *, uncoupled):
    """A body of points; `uncoupled`: in modes of its own free vibration, of unit mass."""
    points = random_points(rng, n_mode)
    body = body_of(points)
    if not uncoupled:
        return body
    values, V = eigh(body.stiffness, body.mass)
    body = body_of(replace(points, phi=points.phi @ V, psi=points.psi @ V))
    return body._replace(mass=np.eye(n_mode), stiffness=np.diag(values), damping=np.diag(values))


def test_the_same_place_twice_drives_nothing():
    """Two clamps at one body, or a joint where modes move, are left to the constraints."""
    rng = np.random.default_rng(7)
    body = body_of(random_points(rng, 2))
    still = MarkerTable(0, np.zeros(3), np.eye(3), np.zeros((3, 2)), np.zeros((3, 2)))
    markers = [MarkerTable(-1, np.zeros(3)), still, random_marker(rng, 0, 2)]
    twice = [JointTable("one", "fixed", 0, 1), JointTable("two", "fixed", 0, 1)]
    moving = [JointTable("one", "fixed", 0, 2)]
    for joints in (twice, moving):
        assert list(assemble_model([body], markers, joints).layout.base) == [0]


def test_mechanism_without_constraints():
    rng = np.random.default_rng(5)
    model = assemble_model([body_of(random_points(rng, m)) for m in (1, 0)], [], [])
    work = new_workspace(model)
    evaluate(model, work, 0.0, random_state(rng, model))
    for i in range(2):
        work.factors.L[i] = work.M[i]
    factorise(model.layout, model.layout.mass, work.factors, work.J, work.softness)
    assert work.factors.regular[0] == 1.0
    f = rng.normal(size=model.n_vel)
    order = model.layout.mass
    loads = blocks(model, f)
    solve(model.layout, order, work.factors, loads, work.gamma, work.acceleration, work.left)
    expected = np.linalg.solve(dense(model, work).M, f)
    np.testing.assert_allclose(whole(model, work.acceleration), expected, atol=1e-12)
