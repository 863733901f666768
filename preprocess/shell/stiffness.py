"""Stiffness of shell elements: a membrane, a plate and their coupling, rotated to the axes of G.

In E the degrees of freedom of each corner are (u, v, tz) of the membrane and (w, bx, by) of the
plate. Triangles are here, quadrilaterals in quad_stiffness.py.
"""

from typing import Protocol

import numpy as np

from ...solver.math.arrays import Array
from .choice import Choice
from .drilling import DRILLINGS
from .membranes import MEMBRANES, MembraneStrains
from .plates import PLATES, PlateStrains
from .quad_stiffness import quad_stiffness
from .quadrilaterals import Quadrilaterals
from .rotation import to_G, together
from .triangles import Triangles

AT_A_TIME = 256  # elements per block, so that intermediate arrays stay in the cache


class Stiffness(Protocol):
    """Laminate data that an element needs, in E; the first axis c or 1 is optional."""

    @property
    def A(self) -> Array:
        """Membrane, (3, 3) [N/m]."""

    @property
    def B(self) -> Array:
        """Coupling, (3, 3) [N]."""

    @property
    def D(self) -> Array:
        """Bending, (3, 3) [N m]."""

    @property
    def Ds(self) -> Array:
        """Transverse shear, corrected, (2, 2) [N/m]."""


def element_stiffness(t: Triangles | Quadrilaterals, laminate: Stiffness, choice: Choice) -> Array:
    """Stiffness of shell elements in G, (c, 18, 18) or (c, 24, 24) [N/m, N, N m].

    Paper: Eq. (25), Eq. (26).

    Parameters
    ----------
    t : c triangles or quadrilaterals
    laminate : A, B, D, Ds in E, one for all or one for each triangle
    choice : plate, membrane, drilling

    Raises
    ------
    ShellError
        for a choice that does not exist
    """
    choice.checked()
    given = cell_stiffness(laminate)
    size = 6 * t.xy_E.shape[1]
    K_G = np.empty((len(t), size, size))
    for first in range(0, len(t), AT_A_TIME):
        some = slice(first, first + AT_A_TIME)
        A, B, D, Ds = (a[some] if len(a) > 1 else a for a in given)
        part = t[some]
        if isinstance(part, Quadrilaterals):
            K_G[some] = quad_stiffness(part, A, B, D, Ds, choice)
        else:
            K_G[some] = _stiffness(part, A, B, D, Ds, choice)
    return K_G


def cell_stiffness(laminate: Stiffness) -> tuple[Array, Array, Array, Array]:
    """A, B, D (c|1, 3, 3) and Ds (c|1, 2, 2), from one laminate for all or one for each."""
    A, B, D = (
        np.asarray(a, dtype=float).reshape(-1, 3, 3) for a in (laminate.A, laminate.B, laminate.D)
    )
    return A, B, D, np.asarray(laminate.Ds, dtype=float).reshape(-1, 2, 2)


def _stiffness(t: Triangles, A: Array, B: Array, D: Array, Ds: Array, choice: Choice) -> Array:
    membrane = MEMBRANES[choice.membrane].strains(t, A, choice.beta0)
    plate = PLATES[choice.plate].strains(t, D, Ds)
    K_m = membrane_stiffness(t, A, membrane)
    form = choice.drilling_form()
    if form != "none":
        K_m += DRILLINGS[form].stiffness(t, A, choice.drilling_factor)
    K_b = plate_stiffness(t, D, Ds, plate)
    K_mb = coupling_stiffness(t, B, membrane, plate) if B.any() else None
    return to_G(t.A_GE, together(K_m, K_b, K_mb))


def membrane_stiffness(t: Triangles, A: Array, membrane: MembraneStrains) -> Array:
    """area mean(Bm' A Bm) + extra in the membrane's degrees of freedom, (c, 9, 9)."""
    K = weighted_squares(t, A, membrane.strain)
    return K if membrane.extra is None else K + membrane.extra


def plate_stiffness(t: Triangles, D: Array, Ds: Array, plate: PlateStrains) -> Array:
    """area mean(Bb' D Bb + Bs' Ds Bs) in the plate's degrees of freedom, (c, 9, 9)."""
    K = weighted_squares(t, D, plate.curvature)
    if plate.shear.shape[1]:
        K += weighted_squares(t, Ds, plate.shear)
    return K


def coupling_stiffness(
    t: Triangles, B: Array, membrane: MembraneStrains, plate: PlateStrains
) -> Array:
    """area mean(Bm)' B mean(Bb), rows of the membrane, columns of the plate, (c, 9, 9)."""
    stress = B @ plate.curvature.mean(axis=1)
    return np.asarray(np.swapaxes(membrane.mean_strain, 1, 2) @ (t.area[:, None, None] * stress))


def weighted_squares(t: Triangles, C: Array, strain: Array) -> Array:
    """area mean(strain' C strain) over the q points of strain (c, q, n, 9): (c, 9, 9)."""
    c, q, n, _ = strain.shape
    stress = ((t.area / q)[:, None, None] * C)[:, None] @ strain
    return np.asarray(np.swapaxes(strain.reshape(c, q * n, 9), 1, 2) @ stress.reshape(c, q * n, 9))
