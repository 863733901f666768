"""Points, deflections, energies and joint reactions of a state."""

from dataclasses import dataclass

import numpy as np

from ...math.arrays import Array
from ...math.rotations import rotation_matrices
from ..elements.joints.table import position_rows
from ..evaluation import series
from ..evaluation.energy import first_moments
from ..model.model import GROUND, Model
from .scales import extent


@dataclass(frozen=True)
class History:
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
    """Evaluate multipliers, energies and constraint violations at states y (k, n)."""
    return history_of(model, y, series.along(model, t, y))


def history_of(model: Model, y: Array, along: series.Along) -> History:
    """Return the history of states y (k, n) in which the equations were evaluated."""
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
    """Return r_G (k, 3), A_GB (k, 3, 3) and modal coordinates (k, m) of one body."""
    a, m = int(model.pos_start[body]), int(model.n_mode[body])
    return y[:, a : a + 3], rotation_matrices(y[:, a + 3 : a + 7]), y[:, a + 7 : a + 7 + m]


def stiffened(model: Model, body: int) -> bool:
    """True if a body has second-order displacements (geometric stiffening)."""
    return bool(model.second_start[body + 1] > model.second_start[body])


LOADED = 1e-3  # least load, over that which the kinetic energy stands for

# Central differences, exact for polynomials up to the sixth degree.
DIFFERENCE = ((-3, -1 / 60), (-2, 3 / 20), (-1, -3 / 4), (1, 3 / 4), (2, -3 / 20), (3, 1 / 60))


def joint_reactions(model: Model, t: Array, y: Array, multipliers: Array) -> Array:
    """Return force [N] and moment [N m] of each joint on its two sides, (k, nj, 2, 6).

    At times t (k,), states y (k, n) and multipliers (k, n_c). Global components; the moment is
    about the origin of that side's marker. For redundant joints they are those of least norm.
    """
    n = model.joint_marker.size
    return series.marker_loads(model, t, y, multipliers)[:, :n].reshape(len(y), -1, 2, 6)


def momentum_rates(model: Model, y: Array, rates: Array) -> Array:
    """Return the rates of the momenta of bodies along the solution, (k, nb, 6), by differences.

    They depend on forces and multipliers only through the accelerations, which are part of
    `rates` = dy/dt (k, n). All coordinates are moved along their rates. Momenta are polynomials of
    low degree in them, except for the norm of the Euler parameters, and a body rotates by
    thousandths of a radian.
    """
    parameters = np.asarray(model.pos_start)[:, None] + np.arange(3, 7)
    turning = np.linalg.norm(rates[:, parameters], axis=2).max(axis=1, initial=1.0)
    h = (2e-3 / turning)[:, None]
    found = np.zeros((len(y), model.n_body, 6))
    for s, weight in DIFFERENCE:
        _, moved = series.momenta(model, y + s * h * rates)
        found += weight * moved
    return found / h[:, :, None]


def acting(model: Model, t: Array, y: Array, multipliers: Array) -> tuple[Array, Array]:
    """Return resultants about the global origin of all forces on each body, (k, nb, 6).

    Also returns the sum of their absolute values (k, nb, 6), as scale of an error. The forces are
    weight, force elements, loads and reactions.
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


@dataclass(frozen=True)
class MomentumBalance:
    """Error of d(momentum)/dt = sum of loads and reactions, over the largest term in the run."""

    linear: float
    angular: float


def momentum_balance(model: Model, t: Array, y: Array) -> MomentumBalance:
    """Compare forces with the change of momentum for each body at states y (k, n)."""
    rates, multipliers = series.along_solution(model, t, y)
    total, scale = acting(model, t, y, multipliers)
    error = np.abs(momentum_rates(model, y, rates) - total)
    # In free flight there is no load: what is left is round-off of the inertia terms.
    v = y[:, model.n_pos : model.n_pos + model.n_vel]
    momenta, _ = series.momenta(model, y)
    energy = 0.5 * float(np.abs(v * momenta).sum(axis=1).max())
    least = LOADED * energy * np.array([1.0 / extent(model, y[0]), 1.0])
    largest = np.maximum(scale.reshape(-1, 2, 3).max(axis=(0, 2)), np.maximum(least, 1e-300))
    relative = error.reshape(-1, 2, 3).max(axis=(0, 2)) / largest
    return MomentumBalance(float(relative[0]), float(relative[1]))
