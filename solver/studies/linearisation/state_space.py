"""The equations of motion linearised about a state, with the constraints eliminated.

    eta' = Z+ T Z eta + zeta
    zeta' = (Z+ (da(Z, B) + T_u B) + Zdot' S B) eta + Z+ (da(0, Z) + T_u Z) zeta

The displacement is x = Z eta, the change of velocity u = Z zeta + B eta, with Z the free motions
and B what the constraints ask of the velocities of a displaced state. In a state that moves, the
free motions change: Zdot = (1 - Z Z+) (B + T Z), zero in steady spin. da are derivatives of the
accelerations that solve (12), so that they contain inertia, gyroscopic terms, following loads and
the change of the constraint forces. Auxiliary states of controllers and friction follow. A drive
enters by its acceleration, with two states: what its coordinate and its rate are beside their law.
Reasons: docs/adr/0020.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import qr

from ...dynamics.analysis.rank import FreeMotions, Rank, free_motions
from ...dynamics.analysis.recovery import extent
from ...dynamics.elements.forces.table import unit_of_law
from ...dynamics.elements.joints.table import DRIVES, NAMES, position_rows
from ...dynamics.evaluation.accelerations import assemble
from ...dynamics.evaluation.laws import law_values
from ...dynamics.evaluation.series import along_solution, balance
from ...dynamics.model.coordinates import Spin, spin_accelerations, spin_velocities
from ...dynamics.model.model import Model
from ...inputs.case.expressions import drives
from ...math.arrays import Array, IntArray
from ...math.rotations import rotation_matrix, skew
from ...mechanism.built_mechanism import BuiltMechanism
from ...signals import Recording, Sensor
from .differences import Instant, derivatives

if TYPE_CHECKING:
    from ...inputs.case.tables.schema import Mechanism


_ALIKE = 1e-6  # of the largest acceleration by the spin


class Frame(NamedTuple):
    """Rates of displacements and velocities that the turning of axes adds (docs/adr/0020)."""

    T: Array  # (n_vel, n_vel): x' = u + T x
    T_u: Array  # (n_vel, n_vel): u' = a + T_u u


def turning_axes(model: Model, y: Array, W_G: Array) -> Frame:
    """Return the terms of axes that turn at W_G (3,) [rad/s], in state y (n,).

    Translations: -W x in both. Rotations, in body axes that turn at w0: -W x for displacements,
    (w0 - W) x for velocities, so that both are seen from axes that turn at W. Modes: none.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    W_G : angular velocity of the axes (3,) [rad/s]
    """
    T, T_u = np.zeros((model.n_vel, model.n_vel)), np.zeros((model.n_vel, model.n_vel))
    for i in range(model.n_body):
        a, j = int(model.pos_start[i]), int(model.vel_start[i])
        A = rotation_matrix(y[a + 3 : a + 7])
        W_B = A.T @ W_G
        w0 = y[model.n_pos + j + 3 : model.n_pos + j + 6]
        T[j : j + 3, j : j + 3] = T_u[j : j + 3, j : j + 3] = -skew(W_G)
        T[j + 3 : j + 6, j + 3 : j + 6] = -skew(W_B)
        T_u[j + 3 : j + 6, j + 3 : j + 6] = skew(w0 - W_B)
    return Frame(T, T_u)


def common_spin(model: Model, t: float, y: Array) -> Spin | None:
    """Return the constant spin at which the whole mechanism turns in state y; None: it does not.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    v = y[model.n_pos : model.n_pos + model.n_vel]
    first = int(model.vel_start[0])
    a = int(model.pos_start[0])
    W = rotation_matrix(y[a + 3 : a + 7]) @ v[first + 3 : first + 6]
    rate = float(np.linalg.norm(W))
    if rate == 0.0:
        return None
    r0, v0 = y[a : a + 3], v[first : first + 3]
    # the point of the axis nearest to the first frame
    spin = Spin(W / rate, r0 + np.cross(W, v0) / rate**2, rate)
    if np.abs(spin_velocities(model, y, spin) - v).max() > _ALIKE * np.abs(v).max():
        return None
    expected = spin_accelerations(model, y, spin)
    rates = along_solution(model, np.full(1, t), y[None])[0][
        0, model.n_pos : model.n_pos + model.n_vel
    ]
    scale = max(float(np.abs(expected).max()), rate**2)
    return spin if np.abs(rates - expected).max() <= _ALIKE * scale else None


_STEADY = 1e-6  # change of the free motions in steady spin, relative to the spin's velocities


class Source(NamedTuple):
    """A law of time that may be an input: a drive, an actuator or a load."""

    name: str
    law: int  # number in the model
    unit: str  # of its value
    drive: bool  # it enters by its acceleration


@dataclass(frozen=True)
class StateSpace:
    """x' = A x + B u, y = C x + D u about a state.

    x = [eta, zeta, auxiliary states, drives, their rates].
    """

    A: Array  # (n, n)
    B: Array  # (n, n_in)
    C: Array  # (n_out, n)
    D: Array  # (n_out, n_in)
    free: FreeMotions  # Z, its inverse and the rank
    velocity: Array  # (n_vel, n_free) B of u = Z zeta + B eta
    mass: Array  # (n_vel, n_vel) mass matrix of the state
    inertia_scale: Array  # (n_vel,) of the model
    y: Array  # (n_y,) the state about which
    auxiliary: IntArray  # (n_a,) numbers of the auxiliary states that have a rate
    acceleration: Array  # (n_vel,) of that state, in the axes of the linearisation
    auxiliary_rates: Array  # (n_a,) of that state
    forces: Array  # (n_vel,) that act on it
    inputs: tuple[Source, ...]
    outputs: tuple[tuple[str, str], ...]  # name and unit
    error: float  # estimate of the relative error of A

    @property
    def n_free(self) -> int:
        """Number of free motions."""
        return self.free.Z.shape[1]

    @property
    def rank(self) -> Rank:
        """Rank of the constraint rows."""
        return self.free.rank

    @property
    def A_free(self) -> Array:
        """A without the states of drives, (m, m), m = 2 n_free + n_a."""
        m = 2 * self.n_free + self.auxiliary.size
        return self.A[:m, :m]

    def displacements(self, columns: Array) -> Array:
        """Return x (n_vel, k) for columns (m, k) of states without drives."""
        return np.asarray(self.free.Z @ columns[: self.n_free])

    def velocities(self, columns: Array) -> Array:
        """Return u (n_vel, k) for columns (m, k) of states without drives."""
        n = self.n_free
        return np.asarray(self.free.Z @ columns[n : 2 * n] + self.velocity @ columns[:n])


def linearise(
    model: Model,
    t: float,
    y: Array,
    W_G: Array,
    *,
    sensors: Mapping[str, Sensor] | None = None,
    sources: Sequence[Source] = (),
) -> StateSpace:
    """Return the equations of motion linearised about state y (n,) at time t.

    Parameters
    ----------
    W_G : (3,) angular velocity of the axes in which displacements are seen, global [rad/s]
    sensors : outputs
    sources : inputs
    """
    sensors = sensors or {}
    y = y.copy()
    y[-1] = 0.0
    free = free_motions(assemble(model, t, y), model.inertia_scale)
    model = model._replace(alpha=0.0, beta=0.0, penalty=0.0, redundant=free.rank.redundant)
    at = Instant(model, t, y, law_values(model, t))
    size = extent(model, y)
    Z, left = free.Z, free.Z_left
    # Those that count turns of an angle, or are sampled, do not change in a small motion.
    auxiliary = np.flatnonzero((model.quantities.rate >= 0) & (model.quantities.of_coordinate < 0))
    drives = [s for s in sources if s.drive]
    n, n_a, n_d = Z.shape[1], auxiliary.size, len(drives)

    # One row for each state: displacement, change of velocity, auxiliary states, laws.
    n_v, of_laws, n_state = model.n_vel, 2 * model.n_vel + model.n_aux, 2 * n + n_a + 2 * n_d
    width = of_laws + at.laws.size

    def answers(directions: Array, column: int) -> Array:
        """Motions (n_vel, k) that restore Phi (column 0) or Phidot (1) along directions."""
        weights = np.ones(2 * model.n_constraint)
        blocks = derivatives(at, _constraints, directions, size, weights).values
        return np.asarray(-free.P @ blocks.reshape(2, -1, len(directions))[column])

    B = np.zeros_like(Z)
    if model.n_constraint and (y[model.n_pos :].any() or at.laws[:, 1].any()):
        B = answers(np.pad(Z.T, ((0, 0), (0, width - n_v))), 1)
    X, Xp = np.zeros((n_v, n_d)), np.zeros((n_v, n_d))
    if drives:
        moving = np.zeros((n_d, width))
        moving[np.arange(n_d), [of_laws + 3 * s.law for s in drives]] = 1.0
        moving[:, :n_v] = (X := answers(moving, 0)).T
        Xp = answers(moving, 1)
    x = np.hstack([Z, np.zeros_like(Z), np.zeros((n_v, n_a)), X, np.zeros_like(X)])
    u = np.hstack([B, Z, np.zeros((n_v, n_a)), Xp, X])
    directions = np.zeros((n_state + len(sources), width))
    directions[:n_state, : 2 * n_v] = np.vstack([x, u]).T
    directions[2 * n + np.arange(n_a), 2 * n_v + auxiliary] = 1.0
    for k, s in enumerate(drives, 2 * n + n_a):
        for order in (0, 1):
            directions[k + order * n_d, of_laws + 3 * s.law + order] = 1.0
    for k, s in enumerate(sources, n_state):
        directions[k, of_laws + 3 * s.law + (2 if s.drive else 0)] = 1.0
    first = model.n_pos + model.n_vel
    kept = [*range(model.n_pos, first), *(first + auxiliary)]

    def evaluation(m: Model, times: Array, states: Array) -> Array:
        rates = along_solution(m, times, states)[0][:, kept]
        recording = Recording(m, times, states)
        return np.column_stack([rates, *(s.values(recording) for s in sensors.values())])

    weights = np.concatenate([np.sqrt(model.inertia_scale), np.zeros(n_a + len(sensors))])
    blocks = derivatives(at, evaluation, directions, size, weights)
    da, ds, dy = np.split(blocks.values, [model.n_vel, model.n_vel + n_a])
    frame = turning_axes(model, y, W_G)
    A, into = np.zeros((n_state, n_state)), np.zeros((n_state, len(sources)))
    A[:n] = left @ (u + frame.T @ x)
    A[n : 2 * n] = left @ (da[:, :n_state] + frame.T_u @ u)
    # Free motions change along a motion: Zdot, without a component in Z.
    beside = np.eye(model.n_vel) - Z @ left
    Z_d = beside @ (B + frame.T @ Z)
    least = _STEADY * max(float(np.linalg.norm(B, axis=0).max(initial=0.0)), 1e-300)
    Z_d[:, np.linalg.norm(Z_d, axis=0) <= least] = 0.0  # the round-off of B
    change = Z_d.T * model.inertia_scale
    A[:n] += change @ beside @ x
    A[n : 2 * n] += change @ beside @ u
    A[2 * n : 2 * n + n_a], into[2 * n : 2 * n + n_a] = ds[:, :n_state], ds[:, n_state:]
    A[n_state - 2 * n_d : n_state - n_d, n_state - n_d :] = np.eye(n_d)
    into[n : 2 * n] = left @ da[:, n_state:]
    for k, s in enumerate(sources):
        if s.drive:
            into[n_state - n_d + drives.index(s), k] = 1.0
    rest = along_solution(model, np.full(1, t), y[None])[0][0, kept]
    # The largest estimated error of a column over its size. A large acceleration that does not
    # depend on the state leaves nothing but round-off.
    errors = np.linalg.norm(left @ blocks.errors[:n_v, : 2 * n], axis=0)
    sizes = np.linalg.norm(left @ da[:, : 2 * n], axis=0)
    noise = 1e-8 * float(np.linalg.norm(left @ rest[:n_v]))
    least = max(1e-9 * max(float(sizes.max(initial=0.0)), 1.0), noise)
    return StateSpace(
        A=A,
        B=into,
        C=dy[:, :n_state],
        D=dy[:, n_state:],
        free=free,
        velocity=B,
        mass=assemble(model, t, y).M,
        inertia_scale=model.inertia_scale,
        y=y,
        auxiliary=auxiliary,
        acceleration=rest[: model.n_vel] + frame.T_u @ y[model.n_pos : first],
        auxiliary_rates=rest[model.n_vel :],
        forces=assemble(model, t, y).f,
        inputs=tuple(sources),
        outputs=tuple((name, s.unit) for name, s in sensors.items()),
        error=float(np.max(errors / np.maximum(sizes, least), initial=0.0)),
    )


def _constraints(model: Model, t: Array, y: Array) -> Array:
    """Phi and Phidot of states, (k, 2 n_c)."""
    b = balance(model, t, y)
    return np.hstack([b.Phi, b.Phi_d])


class Realisation(NamedTuple):
    """x' = A x + B u, y = C x + D u with named states, inputs and outputs, in SI units."""

    A: Array  # (n, n)
    B: Array  # (n, n_in)
    C: Array  # (n_out, n)
    D: Array  # (n_out, n_in)
    states: list[str]
    inputs: list[str]
    input_units: list[str]
    outputs: list[str]
    output_units: list[str]
    coordinates: list[str]  # (n_vel,) all velocity coordinates, of the shapes


def realisation(space: StateSpace, coordinates: list[str], auxiliary: list[str]) -> Realisation:
    """Return the equations in the displacements of independent coordinates and their rates.

    Parameters
    ----------
    coordinates : (n_vel,) names of the velocity coordinates
    auxiliary : (n_aux,) names of the auxiliary states

    The coordinates are chosen by a QR decomposition with pivoting of the free motions. A rate is
    the velocity beside that which the constraints ask of the displaced state (zeta of
    state_space.py); where the state is at rest it is the rate of the coordinate.
    """
    Z, n = space.free.Z, space.n_free
    root = np.sqrt(space.inertia_scale)[:, None]
    order: Array = qr((root * Z).T, pivoting=True, mode="r")[1] if n else np.zeros(0)
    chosen = sorted(int(k) for k in order[:n])
    S = np.eye(len(space.A))
    S[:n, :n] = S[n : 2 * n, n : 2 * n] = Z[chosen]
    inverse = np.linalg.inv(S)
    drives = [s.name for s in space.inputs if s.drive]
    others = [auxiliary[j] for j in space.auxiliary]
    return Realisation(
        A=S @ space.A @ inverse,
        B=S @ space.B,
        C=space.C @ inverse,
        D=space.D,
        states=[
            *(coordinates[k] for k in chosen),
            *(f"rate of {coordinates[k]}" for k in chosen),
            *others,
            *drives,
            *(f"rate of {name}" for name in drives),
        ],
        inputs=[s.name for s in space.inputs],
        input_units=[s.unit for s in space.inputs],
        outputs=[name for name, _ in space.outputs],
        output_units=[unit for _, unit in space.outputs],
        coordinates=coordinates,
    )


def frequency_response(space: StateSpace, w: Array) -> Array:
    """Return G = C (i w - A)^-1 B + D at angular frequencies w (k,), (k, n_out, n_in) complex.

    An input is the size of a load or actuator, or the acceleration of a drive.
    """
    unit = np.eye(len(space.A))
    return np.array(
        [space.C @ np.linalg.solve(1j * x * unit - space.A, space.B) + space.D for x in w]
    ).reshape(len(w), *space.D.shape)


def frequencies_between(low: float, high: float, count: int, resonances: Array) -> Array:
    """Return rising angular frequencies, evenly on a logarithmic scale and close to resonances.

    Parameters
    ----------
    low : lowest angular frequency [rad/s]
    high : highest one [rad/s]
    count : number on the logarithmic scale
    resonances : angular frequencies of the modes (k,) [rad/s]
    """
    near = np.concatenate([[-d, d] for d in (1e-2, 3e-3, 1e-3, 1e-4)]).ravel()
    beside = np.outer(resonances, 1.0 + near).ravel()
    w = np.concatenate([np.geomspace(low, high, count), beside])
    return np.unique(w[(w >= low) & (w <= high)])


def sources_of(mechanism: "Mechanism", built: BuiltMechanism) -> tuple[Source, ...]:
    """Return one input per law of time: "JOINT:DRIVE" by its acceleration, "FORCE" by its size."""
    model, sources = built.model, []
    for name, joint in mechanism.joints.items():
        for key, row in zip(drives(joint), built.joints[name].rows[1:], strict=True):
            assert NAMES[model.joint_kind[row]] in DRIVES
            first = int(model.joint_row[row])
            unit = "m" if position_rows(model.joint_kind)[first] else "rad"
            sources.append(Source(f"{name}:{key}", int(model.joint_law[row]), f"{unit}/s2", True))
    for k, (name, force) in enumerate(mechanism.forces.items()):
        law = int(model.force_law[k])
        if law >= 0:
            sources.append(Source(name, law, unit_of_law(force.kind), False))
    return tuple(sources)
