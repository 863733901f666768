"""Physical quantities from the state: points, deflections, reactions, energies."""

from dataclasses import dataclass

import numpy as np

from ..math.arrays import Array
from ..math.rotations import rotation_matrices
from ..package.body.schema import Interface
from . import series
from .joints.table import position_rows
from .model import Model


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


def elastic_motion(place: Interface, q: Array, second_order: bool) -> tuple[Array, Array]:
    """Return translation (k, 3) [m] and rotation vector (k, 3) [rad] of an interface in its body.

    phi q and psi q, and with `second_order` 1/2 q' H q of both. q : (k, m) modal coordinates.
    """
    u, theta = q @ place.phi_B.T, q @ place.psi_B.T
    if second_order and place.H_B is not None and place.H_psi_B is not None:
        u = u + 0.5 * np.einsum("aij,ki,kj->ka", place.H_B, q, q, optimize=True)
        theta = theta + 0.5 * np.einsum("aij,ki,kj->ka", place.H_psi_B, q, q, optimize=True)
    return u, theta
