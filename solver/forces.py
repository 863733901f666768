"""Inertia and weight carried at markers."""

from .bodies.marker import Marker
from .compiled import jit
from .package.schema import Array
from .small import mm, tv


@jit
def add_point_mass(M: Array, f: Array, marker: Marker, mass: float, gravity_G: Array) -> None:
    """Add a point mass at `marker` to its body's blocks M (n, n) and f (n,) in place.

    The mass point moves with the marker, v = J_v (rdot, w, qdot): no unknowns
    and no constraints of its own, and the same motion as a rigid body of no
    size that is joined there.
    """
    M += mass * mm(marker.J_v.T, marker.J_v)
    f += mass * tv(marker.J_v, gravity_G - marker.a)
