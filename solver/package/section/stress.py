"""Stresses in a section under unit resultants, and the trapeze effect that follows from them."""

import numpy as np

from ...math.arrays import Array
from ..common.materials import bond
from ..common.remark import Remark
from .schema import RESULTANTS, SectionFile, SectionRecovery


def unit_stress(recovery: SectionRecovery) -> Array:
    """Stress of every integration point in section axes, per unit resultant.

    Returns
    -------
    (p, 6, 6) [Pa/N, Pa/(N m)]: rows 11, 22, 33, 23, 13, 12, a column for each resultant
    """
    stress_M = recovery.C_M[recovery.ply] @ recovery.strain_M
    return np.asarray(bond(recovery.A_BM) @ stress_M)


def cell_means(section: SectionFile, values: Array) -> Array:
    """Mean over each cell of values at the integration points, (p, ...) to (c, ...)."""
    recovery, n_cell = section.recovery, len(section.mesh.cell_types)
    sums, weights = np.zeros((n_cell, values[0].size)), np.zeros(n_cell)
    flat = values.reshape(len(values), -1) * recovery.weights[:, None]
    # points have any order; sorted by cell, the points of a cell are contiguous
    order = np.argsort(recovery.cell, kind="stable")
    cells, first = np.unique(recovery.cell[order], return_index=True)
    sums[cells] = np.add.reduceat(flat[order], first)
    weights[cells] = np.add.reduceat(recovery.weights[order], first)
    return (sums / weights[:, None]).reshape(n_cell, *values.shape[1:])


def resultants(recovery: SectionRecovery, stress: Array) -> Array:
    """Resultants [F1 F2 F3 M1 M2 M3] of stresses (p, 6, ...), (6, ...).

    F1 = int s11, F2 = int s12, F3 = int s13, M1 = int x2 s13 - x3 s12, M2 = int x3 s11,
    M3 = -int x2 s11.
    """
    x2, x3 = recovery.points.T
    zero, one = np.zeros_like(x2), np.ones_like(x2)
    weight_11 = np.stack([one, zero, zero, zero, x3, -x2])
    weight_13 = np.stack([zero, zero, one, x2, zero, zero])
    weight_12 = np.stack([zero, one, zero, -x3, zero, zero])
    return np.asarray(
        sum(
            np.tensordot(weight * recovery.weights, stress[:, row], axes=1)
            for weight, row in ((weight_11, 0), (weight_13, 4), (weight_12, 5))
        )
    )


def unit_resultants_findings(
    path: str, K: Array, recovery: SectionRecovery, limit: float
) -> list[Remark]:
    """Warn if the stresses of a unit resultant do not integrate to it.

    The error is scaled by sqrt(K_jj / K_ii) and compared with `limit`; `path` is that of the
    stresses.
    """
    scale = np.sqrt(np.diag(K))
    back = resultants(recovery, unit_stress(recovery))
    gap = np.abs(back - np.eye(6)) * scale[None, :] / scale[:, None]
    if gap.max() <= limit:
        return []
    i, j = (int(v) for v in np.unravel_index(np.argmax(gap), gap.shape))
    text = (
        f"the stresses of a unit {RESULTANTS[j]} integrate to {RESULTANTS[i]} = {back[i, j]:.9g}, "
        f"expected {float(i == j):g}"
    )
    return [Remark("warning", path, text)]


def trapeze_strains(K: Array, recovery: SectionRecovery) -> Array:
    """Strains a (6,) of a section twisted by 1 rad/m, times -2: (m2, m2, m2, m, m, m).

    A twisted section shortens and, if it is not symmetric, bends. The fibres of a section that
    twists by k1 per length become helices about its shear centre. A fibre at the distance r has the
    second-order strain 1/2 r^2 k1^2 along the beam. Without resultants the section then takes the
    strains e6 = -1/2 a k1^2. With the axial stress s11_j of a unit resultant j, its warping
    included, reciprocity gives

        a_j = int r^2 s11_j dA,   order extension, shear2, shear3, twist, bend2, bend3.

    Of one material a_1 is the polar radius of gyration squared, (b^2 + t^2) / 12 of a rectangle.
    Under the tension N the section resists torsion with N a_1 besides its stiffness.

    Parameters
    ----------
    K : (6, 6) section stiffness, which determines the shear centre
    recovery : stresses of the section per unit resultant
    """
    S = np.linalg.inv(K)
    # u2 = x3c f1 and u3 = -x2c f1 of the reference line, when the shear centre stays in place
    x2, x3 = -S[2, 3] / S[3, 3], S[1, 3] / S[3, 3]
    r2 = (recovery.points[:, 0] - x2) ** 2 + (recovery.points[:, 1] - x3) ** 2
    return np.asarray((recovery.weights * r2) @ unit_stress(recovery)[:, 0])
