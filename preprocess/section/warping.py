"""Warping of the cross-section under the strains of the beam.

Displacement of a section = rigid motion + V0 e + V1 e' with the classical strains
e = [gamma11, kappa1, kappa2, kappa3] of the beam. The columns of V0 and V1 are nodal
values of the warping.

Paper: Eq. (37), Eq. (38).
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ...solver.package.schema import Array
from .. import fenicsx
from .forms import SectionMatrices, SectionSpace
from .mesh import SectionError

# Load must not work on a rigid motion: relative work that round-off may leave.
SOLVABILITY = 1e-10


def beam_strain_fields(space: SectionSpace) -> Array:
    """Psi (n_dof, 4): strain of point (x2, x3) is G_l Psi e where nothing warps.

    Columns e1, (0, -x3, x2), x3 e1, -x2 e1 for e = [gamma11, kappa1, kappa2, kappa3]: the
    derivative along the beam of the rigid motion of its sections.
    """
    x2, x3 = space.x2, space.x3
    return space.displacements((1, 0, 0), (0, -x3, x2), (x3, 0, 0), (-x2, 0, 0))


def rigid_fields(space: SectionSpace) -> Array:
    """(n_dof, 4) motions of the section that strain nothing within it: the null space of E."""
    return space.displacements((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -space.x3, space.x2))


def pinned_dofs(space: SectionSpace) -> NDArray[np.int64]:
    """Four unknowns that stop the rigid motions: a node, and one component of a far node."""
    a = int(np.argmin(space.x2 + space.x3))
    lever_2, lever_3 = space.x2 - space.x2[a], space.x3 - space.x3[a]
    b = int(np.argmax(np.hypot(lever_2, lever_3)))
    across = 2 if abs(lever_2[b]) >= abs(lever_3[b]) else 1
    return np.array([3 * a, 3 * a + 1, 3 * a + 2, 3 * b + across])


class WarpingSolver:
    """Solves E W = load for warpings that hold no rigid motion.

    Pinning four unknowns keeps the matrix positive definite, hence a Cholesky factorisation.
    Loads that do no work on rigid motions leave the pins without force, so that which ones are
    pinned changes nothing; the rigid part is taken out afterwards.
    """

    def __init__(
        self, space: SectionSpace, E: sp.csr_matrix, pins: NDArray[np.int64] | None = None
    ) -> None:
        self.rigid = rigid_fields(space)
        self._rigid_load = space.area_gram @ self.rigid
        self._rigid_gram = self.rigid.T @ self._rigid_load
        self._free = np.ones(space.n_dof, dtype=bool)
        self._free[pinned_dofs(space) if pins is None else pins] = False
        pinned = E[self._free][:, self._free]
        if pins is not None:
            self._factor = fenicsx.cholesky(pinned)
        elif space.factor is None:
            self._factor = space.factor = fenicsx.cholesky(pinned)
        else:
            self._factor = space.factor
            self._factor.update(pinned)

    def solve(self, load: Array, size: float) -> Array:
        """Warpings (n_dof, k) of loads (n_dof, k).

        `size` is the norm of the terms that the loads were summed from. Raises SectionError if
        the loads work on rigid motions.
        """
        work = np.linalg.norm(self.rigid.T @ load, axis=1) / np.linalg.norm(self.rigid, axis=0)
        if not np.all(work <= SOLVABILITY * size):
            raise SectionError(
                f"the warping has no solution: its load works {np.max(work / size):.1e} (relative) "
                f"on a rigid motion, at most {SOLVABILITY:g} is round-off"
            )
        W = np.zeros_like(load)
        W[self._free] = self._factor.solve(load[self._free])
        return W - self.rigid @ np.linalg.solve(self._rigid_gram, self._rigid_load.T @ W)


def classical_warping(solver: WarpingSolver, matrices: SectionMatrices, Psi: Array) -> Array:
    """V0 (n_dof, 4): warping per unit classical strain, from E V0 = -H Psi.

    Paper: Eq. (39), corrected: "D" stands for the identity, and the projection onto the rigid
    fields vanishes because H Psi does no work on them.
    """
    load = -(matrices.H @ Psi)
    return solver.solve(load, float(np.linalg.norm(load)))


def shear_load(matrices: SectionMatrices, Psi: Array, V0: Array, T: Array) -> Array:
    """Right-hand side (H' V0 + L Psi - H V0) T of the warping under shear, (n_dof, 2).

    `T` (4, 2) gives the change of the classical strains along the beam by the shear forces,
    e' = T [F2, F3].
    """
    return (matrices.H.T @ V0 + matrices.L @ Psi - matrices.H @ V0) @ T


def shear_warping(
    solver: WarpingSolver, matrices: SectionMatrices, Psi: Array, V0: Array, T: Array
) -> Array:
    """V1 (n_dof, 2): warping per unit shear force [F2, F3].

    Paper: Eq. (40), per shear force instead of per e': only the e' that equilibrium allows
    leave a load that does no work on rigid motions, so that the projection is not needed.
    """
    size = np.linalg.norm(matrices.L @ Psi @ T) + np.linalg.norm(matrices.H @ V0 @ T)
    return solver.solve(shear_load(matrices, Psi, V0, T), float(size))
