"""Strains at every point of the section from the six resultants."""

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.common.materials import bond
from ....solver.package.section.schema import SectionRecovery
from ..space.layers import Layup
from ..space.space import SectionSpace
from .helical import CentralSolutions
from .timoshenko import CLASSICAL, SHEAR, SectionStiffness
from .twist import TwistedStrains
from .warping import beam_strain_fields


def unit_displacements(space: SectionSpace, result: SectionStiffness) -> tuple[Array, Array]:
    """Warping w and w' + Psi e of the six unit resultants, each (n_dof, 6).

    Strain of point = G_h w + G_l (w' + Psi e). With the shear forces F_s constant along the
    beam, e' = T F_s, e = A^-1 (F_c - (B - B') e'), w = V0 e + V1 F_s and w' = V0 e'.

    Paper: Eq. (37), Eq. (38), in reverse.
    """
    F = np.eye(6)
    F_c, F_s = F[CLASSICAL], F[SHEAR]
    change = result.T @ F_s
    e = np.linalg.solve(result.A, F_c - (result.B - result.B.T) @ change)
    w = result.V0 @ e + result.V1 @ F_s
    return w, result.V0 @ change + beam_strain_fields(space) @ e


def unit_strains(space: SectionSpace, result: SectionStiffness | CentralSolutions) -> Array:
    """Strains of the six unit resultants at the points of a space, (c, q, 6, 6), own cells."""
    if isinstance(result, CentralSolutions):
        at = TwistedStrains(space, result.strains.k)
        return at.strain_in_section(result.W) + at.strain_along_beam(result.Q)
    w, along = unit_displacements(space, result)
    return space.strain_in_section(w) + space.strain_along_beam(along)


def unit_warping(space: SectionSpace, result: SectionStiffness | CentralSolutions) -> Array:
    """Displacements (n_dof, 6) of the six unit resultants without rigid motion of the section."""
    if not isinstance(result, CentralSolutions):
        return unit_displacements(space, result)[0]
    rigid = result.strains.Z
    load = space.load(space.at_points(rigid))
    return np.asarray(result.W - rigid @ np.linalg.solve(rigid.T @ load, load.T @ result.W))


def section_recovery(
    space: SectionSpace,
    lay: Layup,
    strain_B: Array,
    materials: dict[str, dict[str, object]],
) -> SectionRecovery:
    """Data for the recovery of ply stresses.

    Parameters
    ----------
    space : its points become the points of recovery
    lay : plies at these points
    strain_B : `unit_strains` at these points
    materials : constants by name, as described
    """
    c, q = space.weights.shape
    A_BM = np.broadcast_to(lay.A_BM, (c, q, 3, 3))
    # work is the same in both axes: stress_B = T stress_M, so strain_M = T' strain_B
    strain_M = np.swapaxes(bond(lay.A_BM), -1, -2) @ strain_B
    real = space.weights.ravel() > 0.0  # not those that fill up cells with fewer points
    return SectionRecovery(
        points=space.points.reshape(-1, 2)[real],
        weights=space.weights.ravel()[real],
        cell=np.repeat(np.arange(c), q)[real],
        ply=lay.ply.ravel()[real],
        A_BM=A_BM.reshape(-1, 3, 3)[real],
        strain_M=strain_M.reshape(-1, 6, 6)[real],
        C_M=lay.stiffness_M,
        plies=lay.plies,
        materials=materials,
    )
