"""What an integrator of constrained systems sees of a mechanism: closures, never a body.

M a + Phi_q' lambda = f,  Phi(q, t) = 0,  with velocities v that need not be rates of the
position coordinates q: a step of the velocity coordinates moves q by `move`.
State y = [q (n_pos) | v (n_vel) | work].
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from ...math.arrays import Array
from .base import Derivative


class Terms(Protocol):
    """The equations at one (t, y)."""

    @property
    def M(self) -> Array:
        """Mass matrix (n_vel, n_vel)."""

    @property
    def f(self) -> Array:
        """Forces (n_vel,), all but those of the constraints."""

    @property
    def Phi_q(self) -> Array:
        """Constraint Jacobian (n_c, n_vel): Phidot = Phi_q v + Phi_t."""

    @property
    def Phi(self) -> Array:
        """Constraints (n_c,)."""

    @property
    def Phi_t(self) -> Array:
        """Part of Phidot that comes from time (n_c,)."""

    @property
    def power(self) -> Array:
        """Power of what is not conservative, (1,), constraints that move in time left out."""


@dataclass(frozen=True)
class ConstrainedSystem:
    """A mechanism as closures over its model."""

    n_pos: int
    n_vel: int
    inertia_scale: Array  # (n_vel,) typical inertia of each velocity, for scaling only
    terms: Callable[[float, Array], Terms]
    accelerations: Callable[[float, Array], tuple[Array, Array]]  # and multipliers, at (t, y)
    derivative: Derivative  # dy/dt of the index-1 form
    rates: Callable[[Array, Array], Array]  # (q, v) -> dq/dt (n_pos,)
    move: Callable[[Array, Array], Array]  # (q, step (n_vel,)) -> q
