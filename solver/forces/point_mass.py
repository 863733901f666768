"""Inertia and weight carried at markers."""

from ..bodies.marker import Marker
from ..compiled import jit
from ..package.schema import Array
from ..small import add, mm, tv


@jit
def add_point_mass(M: Array, f: Array, marker: Marker, mass: float, gravity_G: Array) -> None:
    """Add a point mass at `marker` to its body's blocks M (n, n) and f (n,) in place.

    The mass point moves with the marker, v = J_v (rdot, w, qdot): no unknowns
    and no constraints of its own, and the same motion as a rigid body of no
    size that is joined there.
    """
    load = tv(marker.J_v, gravity_G - marker.a)
    for i in range(f.shape[0]):
        f[i] += mass * load[i]
    add(M, 0, 0, mm(marker.J_v.T, marker.J_v), mass)
