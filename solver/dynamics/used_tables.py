"""Which second-order tables of bodies and markers are more than round-off."""

import numpy as np

from ..math.arrays import Array
from ..package.body.schema import Invariants
from .model import GROUND
from .tables import Body, MarkerTable

# Second-order tables below this fraction of the others are round-off: in-plane bending moves no
# station out of the plane.
NOTHING = 1e-12


def marker_second_order(bodies: list[Body], marker: MarkerTable) -> Array:
    """Second-order tables of a marker, (6, m, m); empty for a linear body."""
    if marker.body == GROUND or bodies[marker.body].second_order is None:
        return np.zeros((6, 0, 0))
    if marker.H is None or marker.H_psi is None:
        name = bodies[marker.body].name
        raise ValueError(f"a marker on {name} has no H, H_psi: a stiffened body needs them")
    return np.concatenate([marker.H, marker.H_psi])


def of_moments(Z: Array) -> list[bool]:
    """Return which tables of Z0, Z1 (12, m, m) are above the round-off of the others."""
    return [*_used(Z[:3], 0.0), *_used(Z[3:], 0.0)]


def of_motion(H: Array, marker: MarkerTable) -> list[bool]:
    """The same for a marker's tables (6, m, m), with rotations relative to the square of the first
    order."""
    turn = float(np.abs(marker.psi).max(initial=0.0))
    return [*_used(H[:3], 0.0), *_used(H[3:], turn**2)]


def _used(T: Array, scale: float) -> list[bool]:
    """Return which tables of T (r, m, m) have an entry above round-off."""
    largest = np.abs(T).max(axis=(1, 2), initial=0.0)
    return [bool(x > NOTHING * max(scale, largest.max())) for x in largest]


def pairs_used(invariants: Invariants) -> list[bool]:
    """Return for each pair 3 a + b of axes whether T01 or T11 has an entry there."""
    T01, T11 = invariants.T01_B, invariants.T11_B.transpose(0, 1, 3, 2)
    used = np.abs(T01).max(axis=2, initial=0.0) + np.abs(T11).max(axis=(2, 3), initial=0.0)
    return [bool(u) for u in (used > 0.0).ravel()]
