"""Random flexible bodies of mass points, whose equations can also be written point by point."""

from dataclasses import dataclass

import numpy as np

from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.step_loop import right_hand_side
from plymotion.solver.integrators.table import new_integrator
from plymotion.solver.math.laws import polynomial
from plymotion.solver.math.rotations import rotation_matrix, skew, vector_to_matrix
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import Body, ForceTable, JointTable, MarkerTable
from plymotion.solver.package import from_stations


@dataclass(frozen=True)
class Points:
    """Mass points with rotary inertia and mode shapes, body components."""

    m: np.ndarray
    x: np.ndarray
    phi: np.ndarray
    psi: np.ndarray
    J: np.ndarray

    @property
    def n_mode(self) -> int:
        return self.phi.shape[2]

    def modal_mass(self) -> np.ndarray:
        return np.einsum("k,kai,kaj->ij", self.m, self.phi, self.phi) + np.einsum(
            "kai,kab,kbj->ij", self.psi, self.J, self.psi
        )


def random_points(rng: np.random.Generator, n_mode: int, n_point: int = 7) -> Points:
    J = 0.3 * rng.normal(size=(n_point, 3, 3))
    return Points(
        rng.uniform(0.5, 1.5, n_point),
        rng.normal(size=(n_point, 3)),
        0.3 * rng.normal(size=(n_point, 3, n_mode)),
        0.3 * rng.normal(size=(n_point, 3, n_mode)),
        J @ J.transpose(0, 2, 1),
    )


def body_of(points: Points, stiffness: float = 400.0) -> Body:
    m = points.n_mode
    invariants = from_stations(points.m, points.x, points.phi, points.psi, points.J, "lumped")
    K = np.diag(stiffness * np.arange(1.0, m + 1.0))
    return Body("sample", invariants, points.modal_mass(), K, np.zeros((m, m)))


def random_marker(rng: np.random.Generator, body: int, n_mode: int) -> MarkerTable:
    return MarkerTable(
        body,
        rng.normal(size=3),
        vector_to_matrix(rng.normal(size=3)),
        0.3 * rng.normal(size=(3, n_mode)),
        0.3 * rng.normal(size=(3, n_mode)),
    )


def random_state(rng: np.random.Generator, model: Model, elastic: float = 0.3) -> np.ndarray:
    y = rng.normal(size=model.n_pos + model.n_vel + 1)
    for i in range(model.n_body):
        a = model.pos_start[i]
        y[a + 7 : a + 7 + model.n_mode[i]] *= elastic
    y[-1] = 0.0
    return y


TREE, LOOPS = ("spherical", "revolute", "universal"), ((0, 2), (2, 3))
MODES = (2, 0, 3, 1, 0)


def random_mechanism(seed: int, loops: int) -> Model:
    """Flexible and rigid bodies of random inertia on a random tree; rods close loops; a drive.

    Stands nowhere near its constraints in a random state: no row follows from others.
    """
    rng = np.random.default_rng(seed)
    bodies = [body_of(random_points(rng, m)) for m in MODES]
    markers, joints = [], []

    def marker(body: int) -> int:
        at = MarkerTable(-1, rng.normal(size=3))
        markers.append(at if body < 0 else random_marker(rng, body, MODES[body]))
        return len(markers) - 1

    pairs = [(int(rng.integers(-1, k)), k) for k in range(len(bodies))]
    for k, (one, two) in enumerate([*pairs, *LOOPS[:loops]]):
        kind = TREE[k % 3] if k < len(pairs) else "distance"
        joints.append(JointTable(f"{k}", kind, marker(one), marker(two), parameters=(1.0,)))
    drive = polynomial([0.3, 1.0, 2.0])
    joints.append(JointTable("drive", "rotation_drive", marker(-1), marker(4), drive))
    spring = ForceTable("spring", "spring", marker(0), marker(3), (50.0, 1.0, 0.5))
    return assemble_model(bodies, markers, joints, gravity_G=(1.0, -9.81, 2.0), forces=[spring])


def point_by_point(
    points: Points, K: np.ndarray, y: np.ndarray, gravity: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrix and right-hand side of one free body, summed over its points."""
    m = points.n_mode
    A = rotation_matrix(y[3:7])
    q, w, q_d = y[7 : 7 + m], y[10 + m : 13 + m], y[13 + m : 13 + 2 * m]
    M, f = np.zeros((6 + m, 6 + m)), np.zeros(6 + m)
    for k in range(points.m.size):
        b, b_d = points.x[k] + points.phi[k] @ q, points.phi[k] @ q_d
        J_v = np.hstack([np.eye(3), -A @ skew(b), A @ points.phi[k]])
        J_w = np.hstack([np.zeros((3, 3)), np.eye(3), points.psi[k]])
        bias = A @ (np.cross(w, np.cross(w, b)) + 2 * np.cross(w, b_d))
        M += points.m[k] * J_v.T @ J_v + J_w.T @ points.J[k] @ J_w
        f += J_v.T @ (points.m[k] * (gravity - bias))
        f[3:6] -= np.cross(w, points.J[k] @ (w + points.psi[k] @ q_d))
    f[6:] -= K @ q
    return M, f


def momenta(model: Model, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum and angular momentum about the global origin of a system."""
    M = assemble(model, 0.0, y).M
    p = M @ y[model.n_pos : -1]
    linear, angular = np.zeros(3), np.zeros(3)
    for i in range(model.n_body):
        a, j = model.pos_start[i], model.vel_start[i]
        linear += p[j : j + 3]
        angular += np.cross(y[a : a + 3], p[j : j + 3])
        angular += rotation_matrix(y[a + 3 : a + 7]) @ p[j + 3 : j + 6]
    return linear, angular


def total_energy(model: Model, y: np.ndarray) -> float:
    return float(energies(model, assemble(model, 0.0, y), y).sum())


def simulate(model: Model, y: np.ndarray, times, f=None, rtol: float = 1e-11, name: str = "rk8"):
    """States (k, n) at `times`; f(t, y) replaces the model's own derivative."""
    integrator = new_integrator(
        name,
        f or right_hand_side(model),
        float(times[0]),
        y,
        float(times[-1]),
        rtol=rtol,
        atol=1e-2 * rtol,
    )
    solution = integrate(integrator, times)
    assert solution.status == "finished", solution.message
    return solution.y


def difference(f, h: float = 1e-3) -> np.ndarray:
    """Sixth-order central difference at zero."""
    c = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60
    return sum(ci * f(i * h) for ci, i in zip(c, range(-3, 4), strict=True)) / h
