"""Points, deflections, energies, reactions of states, and the scales of a mechanism."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...math.arrays import Array
from ...math.rotations import rotation_matrices
from ..elements.forces.table import FIRST_LOAD
from ..elements.joints.table import position_rows
from ..evaluation import series
from ..evaluation.energies import stored_energies
from ..evaluation.evaluation import evaluate, first_moments
from ..evaluation.series import along_solution, driven_speeds, marker_places
from ..model.model import GROUND, Model, modal_matrix, spare_workspace
from ..model.motion import ACCELERATION, AXES, PLACE, SPIN, SPIN_RATE, VELOCITY
from ..tolerances import NO_LOAD, ORDER_OF_MAGNITUDE

SAMPLES = 65  # times at which drives are looked at


class Scales(NamedTuple):
    """Orders of magnitude of what a run goes through."""

    length: float  # [m]
    speed: float  # of points [m/s]
    energy: float  # [J]


def scales(model: Model, y0: Array, t_end: float) -> Scales:
    """Return the scales of a run from state y0 (n,) to t_end [s].

    Length: the diagonal of the box around all markers and frames, or the largest radius of
    gyration; 1 m for a mass point without either. Speed: the largest of
    - the speeds at the start, of frames and, by their spin, at the distance of the length;
    - those of drives at any time;
    - the length over t_end;
    - after the length under gravity, or at the accelerations of the start; with springs, bushings
      and dampers, whose accelerations may last for an instant, that of the energy stored in them.
    Energy: that of all masses at this speed.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y0 : state at the start (n,)
    t_end : end of the run [s]
    """
    length = extent(model, y0)
    driven = speed_of_drives(model, y0, np.linspace(0.0, t_end, SAMPLES), length)
    speed = max(length / t_end, _at_start(model, y0, length), driven)
    return Scales(length, speed, float(model.mass.sum()) * speed**2)


def shape_sizes(model: Model, i: int) -> Array:
    """Return the displacement of body i by a unit of each mode, (m,): root mean square by mass."""
    diagonal = modal_matrix(model, model.M_qq, i).diagonal()
    return np.asarray(np.sqrt(diagonal / model.mass[i]))


def sizes_of_motion(model: Model, size: float) -> Array:
    """Return the change of each velocity coordinate that is as large as a turn by 1 rad, (n_vel,).

    Along axes it is the size [m] of the mechanism; of a mode, what moves its body by this size.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    size : of the mechanism [m]
    """
    sizes = np.ones(model.n_vel)
    for i in range(model.n_body):
        j, m = int(model.vel_start[i]), int(model.n_mode[i])
        sizes[j : j + 3] = size
        sizes[j + 6 : j + 6 + m] = size / shape_sizes(model, i)
    return sizes


def extent(model: Model, y0: Array) -> float:
    """Return the size of a mechanism in state y0 (n,), the length of `scales` [m]."""
    frames = y0[np.asarray(model.pos_start)[:, None] + np.arange(3)]
    points = np.concatenate([frames, marker_places(model, y0)])
    box = float(np.linalg.norm(np.ptp(points, axis=0)))
    held = model.mass > 0.0
    moments = np.trace(model.T00 + 0.5 * model.J0, axis1=1, axis2=2)  # rigid bodies are in J0
    with np.errstate(over="raise"):  # of a mass near the least number, which the message names
        square = moments[held] / model.mass[held]
    return max(box, float(np.sqrt(square.max(initial=0.0)))) or 1.0


def _at_start(model: Model, y0: Array, length: float) -> float:
    """Speed at the start, and what gravity and loads can make of it over the length [m/s]."""
    rates, _ = along_solution(model, np.zeros(1), y0[None], ORDER_OF_MAGNITUDE)
    fall = float(np.linalg.norm(model.gravity_G)) * length
    mass = max(float(model.mass.sum()), 1e-300)
    work = spare_workspace(model)
    evaluate(model, work, 0.0, y0)
    energies = np.zeros(3)
    stored_energies(model, y0, work.P, energies)
    stored = energies[1] + work.power[1]
    gain = max(fall, 2.0 * abs(float(stored)) / mass)
    rows = np.diff(model.layout.element_start)
    if not rows[model.force_kind < FIRST_LOAD].any():
        gain = max(
            gain,
            _of_frames(model, rates[0, model.n_pos : model.n_pos + model.n_vel], length) * length,
        )
    return max(
        _of_frames(model, y0[model.n_pos : model.n_pos + model.n_vel], length), float(np.sqrt(gain))
    )


def _of_frames(model: Model, v: Array, length: float) -> float:
    """Return the largest size in v (n_vel,) of frames; of spins, at the distance of the length."""
    first = np.asarray(model.vel_start)[:, None]
    moved = np.linalg.norm(v[first + np.arange(3)], axis=1)
    turned = np.linalg.norm(v[first + np.arange(3, 6)], axis=1) * length
    largest = float(np.max([moved, turned], initial=0.0))
    return largest if np.isfinite(largest) else 0.0


def speed_of_drives(model: Model, y0: Array, times: Array, length: float) -> float:
    """Return the largest speed that drives prescribe at times (k,) [m/s]; of turns, at a length.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y0 : state (n,) whose positions the rows take
    times : times (k,) [s]
    length : arm of rotations [m]
    """
    if not (model.joint_law >= 0).any():
        return 0.0
    arm = np.where(position_rows(model.joint_kind), 1.0, length)
    speeds = driven_speeds(model, times, y0)
    return float(np.fmax.reduce(np.abs(speeds) * arm, axis=None, initial=0.0))


class History(NamedTuple):
    """Quantities along the run at the output times, k of them."""

    multipliers: Array  # (k, n_c); for redundant constraints those of least norm
    energies: dict[str, Array]  # kinetic, strain, potential, drive_work [J], (k,) each
    position_violation: Array  # (k,) largest distance of connected points [m]
    rotation_violation: Array  # (k,) largest misalignment of connected axes [rad]
    velocity_violation: Array  # (k,) largest |Phidot| [m/s, rad/s]

    @property
    def violations(self) -> dict[str, Array]:
        """The three violations by name."""
        return {
            "position": self.position_violation,
            "rotation": self.rotation_violation,
            "velocity": self.velocity_violation,
        }


def history(model: Model, t: Array, y: Array) -> History:
    """Evaluate multipliers, energies and constraint violations at states y (k, n).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    """
    return history_of(model, y, series.along(model, t, y))


def history_of(model: Model, y: Array, along: series.Along) -> History:
    """Return the history of states y (k, n) in which the equations were evaluated.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : states (k, n)
    along : evaluations in these states
    """
    (Phi, Phi_d, energy), distance = along.balance, position_rows(model.joint_kind)
    return History(
        multipliers=along.multipliers,
        energies={
            "kinetic": energy[:, 0],
            "strain": energy[:, 1],
            "potential": energy[:, 2],
            "drive_work": y[:, -1].copy(),
        },
        position_violation=np.abs(Phi[:, distance]).max(axis=1, initial=0.0),
        rotation_violation=np.abs(Phi[:, ~distance]).max(axis=1, initial=0.0),
        velocity_violation=np.abs(Phi_d).max(axis=1, initial=0.0),
    )


def body_frames(model: Model, body: int, y: Array) -> tuple[Array, Array, Array]:
    """Return r_G (k, 3), A_GB (k, 3, 3) and modal coordinates (k, m) of one body.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    body : number of the body
    y : states (k, n)
    """
    a, m = int(model.pos_start[body]), int(model.n_mode[body])
    return y[:, a : a + 3], rotation_matrices(y[:, a + 3 : a + 7]), y[:, a + 7 : a + 7 + m]


def stiffened(model: Model, body: int) -> bool:
    """True if a body has second-order displacements (geometric stiffening)."""
    return bool(model.second_start[body + 1] > model.second_start[body])


# Central differences, exact for polynomials up to the sixth degree.
DIFFERENCE = ((-3, -1 / 60), (-2, 3 / 20), (-1, -3 / 4), (1, 3 / 4), (2, -3 / 20), (3, 1 / 60))


def momentum_rates(model: Model, y: Array, rates: Array) -> Array:
    """Return the rates of the momenta of bodies along the solution, (k, nb, 6), by differences.

    They depend on forces and multipliers only through the accelerations, which are part of
    `rates` = dy/dt (k, n). All coordinates are moved along their rates. Momenta are polynomials of
    low degree in them, except for the norm of the Euler parameters, and a body rotates by
    thousandths of a radian.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : states (k, n)
    rates : dy/dt (k, n)
    """
    parameters = np.asarray(model.pos_start)[:, None] + np.arange(3, 7)
    turning = np.linalg.norm(rates[:, parameters], axis=2).max(axis=1, initial=0.0)
    v = np.abs(y[:, model.n_pos : model.n_pos + model.n_vel])
    moving = (v / sizes_of_motion(model, extent(model, y[0]))).max(axis=1, initial=0.0)
    fastest = np.maximum(turning, moving)
    h = (2e-3 / np.where(fastest > 0.0, fastest, 1.0))[:, None]
    totals = np.zeros((len(y), model.n_body, 6))
    for s, weight in DIFFERENCE:
        _, moved = series.momenta(model, y + s * h * rates)
        totals += weight * moved
    return totals / h[:, :, None]


def acting(model: Model, t: Array, y: Array, multipliers: Array) -> tuple[Array, Array]:
    """Return resultants about the global origin of all forces on each body, (k, nb, 6).

    Also returns the sum of their absolute values (k, nb, 6), as scale of an error. The forces are
    weight, force elements, loads and reactions.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    multipliers : multipliers of the constraints (k, n_c)
    """
    total, scale = np.zeros((2, len(y), model.n_body, 6))
    for i in range(model.n_body):
        a, m = int(model.pos_start[i]), int(model.n_mode[i])
        A = rotation_matrices(y[:, a + 3 : a + 7])
        first = first_moments(model, i, y[:, a + 7 : a + 7 + m])
        arm = model.mass[i] * y[:, a : a + 3] + np.einsum("kab,kb->ka", A, first)
        total[:, i, :3] = model.mass[i] * model.gravity_G
        total[:, i, 3:] = np.cross(arm, model.gravity_G)
    scale += np.abs(total)
    loads, origins = series.loads_of_markers(model, t, y, multipliers)
    loads[:, :, 3:] += np.cross(origins, loads[:, :, :3])
    bodies = model.marker_body[series.loaded_markers(model)]
    order = np.argsort(bodies, kind="stable")[np.count_nonzero(bodies == GROUND) :]
    if order.size:
        loaded, first_row = np.unique(bodies[order], return_index=True)
        total[:, loaded] += np.add.reduceat(loads[:, order], first_row, axis=1)
        scale[:, loaded] += np.add.reduceat(np.abs(loads[:, order]), first_row, axis=1)
    return total, scale


class MomentumBalance(NamedTuple):
    """Error of d(momentum)/dt = sum of loads and reactions, over the largest term in the run."""

    linear: float
    angular: float


def momentum_balance(model: Model, t: Array, y: Array) -> MomentumBalance:
    """Compare forces with the change of momentum for each body at states y (k, n).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    """
    rates, multipliers = series.along_solution(model, t, y)
    total, scale = acting(model, t, y, multipliers)
    error = np.abs(momentum_rates(model, y, rates) - total)
    # Round-off is all that is left of the inertia terms in free flight, and of the moments of a
    # mechanism that hangs at rest.
    v = y[:, model.n_pos : model.n_pos + model.n_vel]
    momenta, _ = series.momenta(model, y)
    energy = 0.5 * float(np.abs(v * momenta).sum(axis=1).max())
    size = extent(model, y[0])
    found = scale.reshape(-1, 2, 3).max(axis=(0, 2))
    force = NO_LOAD * max(energy / size, float(found[0]), 1e-300)
    largest = np.maximum(found, force * np.array([1.0, size]))
    relative = error.reshape(-1, 2, 3).max(axis=(0, 2)) / largest
    return MomentumBalance(float(relative[0]), float(relative[1]))


MARKERS = 32  # whose motions are kept: signals of a place follow each other


# In the memory of a recording, a table: the first values under a key and a body note which points
# govern, later ones are those of the same points. A derivative needs no search.
HELD = "governing points"


class Recording:
    """States y (k, n) of a model at times t (k,); each quantity is computed once.

    Of a long run it is one block after the other: `memory` is what sensors keep of earlier ones,
    the same for all blocks.
    """

    def __init__(
        self, model: Model, t: Array, y: Array, memory: dict[Any, Any] | None = None
    ) -> None:
        self.model, self.t, self.y = model, t, y
        self.memory = {} if memory is None else memory
        self._motions: dict[int, Array] = {}
        self._carried: dict[Any, Array] = {}
        self._shared: dict[Any, Array] = {}

    def carried(self, key: Any, compute: Callable[[Any], tuple[Array, Any]]) -> Array:
        """Return values (k, ...) that depend on those of the block before.

        `compute` gets what it kept of the block before under this key, None in the first; it
        returns the values and what it keeps for the next.
        """
        if key not in self._carried:
            self._carried[key], self.memory[key] = compute(self.memory.get(key))
        return self._carried[key]

    def position(self, marker: int) -> Array:
        """Position (k, 3) of a marker's origin, global [m]."""
        return self._motion(marker)[:, PLACE:AXES]

    def axes(self, marker: int) -> Array:
        """Axes of a marker in columns, global, (k, 3, 3)."""
        return self._motion(marker)[:, AXES:VELOCITY].reshape(-1, 3, 3)

    def velocity(self, marker: int) -> Array:
        """Velocity (k, 3) of a marker's origin, global [m/s]."""
        return self._motion(marker)[:, VELOCITY:SPIN]

    def spin(self, marker: int) -> Array:
        """Angular velocity (k, 3) of a marker, global [rad/s]."""
        return self._motion(marker)[:, SPIN:ACCELERATION]

    def _motion(self, marker: int) -> Array:
        """Row of dynamics/model/motion.py of a marker in every state, (k, 24)."""
        if marker not in self._motions:
            if len(self._motions) >= MARKERS:
                self._motions.pop(next(iter(self._motions)))
            self._motions[marker], _ = series.marker_motions(self.model, marker, self.y)
        return self._motions[marker]

    def modes(self, body: int) -> Array:
        """Modal coordinates (k, m) of a body."""
        a = int(self.model.pos_start[body]) + 7
        return self.y[:, a : a + int(self.model.n_mode[body])]

    def acceleration(self, marker: int) -> Array:
        """Acceleration (k, 3) of a marker's origin, global [m/s2]."""
        body = int(self.model.marker_body[marker])
        if body < 0:
            return np.zeros((len(self.t), 3))
        j = self.model.n_pos + int(self.model.vel_start[body])
        own = self.rates[:, j : j + 6 + int(self.model.n_mode[body])]
        motion, J_m = series.marker_motions(self.model, marker, self.y)
        return np.asarray(
            np.einsum("kan,kn->ka", J_m[:, :3], own) + motion[:, ACCELERATION:SPIN_RATE]
        )

    def reactions(self, rows: tuple[int, ...], side: int) -> Array:
        """Force and moment of joints on their first or second side, (k, 6), global [N, N m].

        Sum over the joint tables `rows` of the model, which have the same markers. Moments
        are about the marker of that side, 1 or 2.
        """
        return self.loads([2 * row + side - 1 for row in rows]).sum(axis=1)

    def loads(self, places: list[int]) -> Array:
        """Force and moment (k, n, 6) of places of `series.loaded_markers`, global [N, N m]."""
        return np.asarray(self._loads[:, places])

    def once(self, key: Any, compute: Callable[[], Array]) -> Array:
        """Return values (k, ...) that several signals of these times need."""
        if key not in self._shared:
            self._shared[key] = compute()
        return self._shared[key]

    @property
    def rates(self) -> Array:
        """Rates (k, n) of the states."""
        return self.along.rates

    @property
    def multipliers(self) -> Array:
        """Multipliers (k, n_c) of the constraints."""
        return self.along.multipliers

    @cached_property
    def along(self) -> series.Along:
        """Rates, multipliers, constraints and energies."""
        return series.along(self.model, self.t, self.y)

    @cached_property
    def _loads(self) -> Array:
        """Force and moment of every joint on its two sides, (k, 2 nj, 6), and of force elements."""
        return series.marker_loads(self.model, self.t, self.y, self.multipliers)


# Of signals: values (k, ...) of a recording; a look at each of its blocks before.
Values = Callable[[Recording], Array]
Look = Callable[[Recording], None]
