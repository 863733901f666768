"""CST: the triangle of constant strain."""

from ..cell import Cell
from .contract import Membrane, MembraneStrains, linear_strain


def cst(t: Cell) -> MembraneStrains:
    """Strains of the linear triangle, (exx, eyy, gxy) = sum_i (gx u, gy v, gy u + gx v)_i.

    It does not depend on tz. Parasitic shear makes it several times too stiff in in-plane
    bending: a wall needs many elements over its height.
    """
    return MembraneStrains([linear_strain(t.points[0], t.corners)], [])


MEMBRANE = Membrane("cst", cst, rotations=False, stiff_in_plane=True)
