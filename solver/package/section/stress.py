"""Stresses in a section: recovery data and their checks, unit resultants, re-entrant corners."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...errors import did_you_mean
from ...math.arrays import Array, IntArray, distinct
from ..common.findings import Remark, Reporter, positive_definite, rotations, rows_of, symmetric
from ..common.materials import MaterialError, PlyStrength, YieldStrength, bond, read_strength
from ..common.recovery_schema import CORNERS, RESULTANTS, SectionRecovery

if TYPE_CHECKING:
    from .section_schema import SectionFile, SectionMeshData

KEPT_BITS = 21  # significant bits: a relative error below 5e-7; with sign and exponent four bytes


def thinned(recovery: SectionRecovery) -> SectionRecovery:
    """The same recovery with strains rounded to a relative 5e-7, compressed to half the size."""
    return replace(recovery, strain_M=rounded(recovery.strain_M))


def rounded(values: Array) -> Array:
    """Numbers with their last bits set to zero: a relative error below 5e-7."""
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.round(np.ldexp(mantissa, KEPT_BITS)), exponent - KEPT_BITS))


class OfMaterials(Protocol):
    """An object with constants and strengths of materials by name."""

    @property
    def materials(self) -> dict[str, dict[str, Any]]:
        """Tables of materials by name."""


def strengths(recovery: OfMaterials) -> dict[str, PlyStrength | YieldStrength]:
    """Strengths of the materials that have any, by name. Raises MaterialError."""
    strengths_by_name = {}
    for name, material in recovery.materials.items():
        if not isinstance(material, Mapping):
            raise MaterialError(f"{name}: expected a table of constants, got {material!r}")
        table = material.get("strength")
        if table is not None:
            strengths_by_name[name] = read_strength(
                table, str(material.get("kind")), f"{name}.strength"
            )
    return strengths_by_name


class OfPlies(OfMaterials, Protocol):
    """An object with plies and their materials by name."""

    @property
    def plies(self) -> Sequence[Any]:
        """Each with the name of its `material`."""


def check_plies(owner: OfPlies, kind: str, where: str, error: Reporter) -> None:
    """Report unknown materials of plies and unusable strengths; `kind` of owner, for messages.

    Parameters
    ----------
    owner : object with plies and materials
    kind : what the owner is, for messages
    where : begin of the path of the dataset, for messages
    error : function that gets path and text of a finding
    """
    for row, ply in enumerate(owner.plies):
        if ply.material not in owner.materials:
            hint = did_you_mean(ply.material, tuple(owner.materials))
            text = f"row {row}: {ply.material!r} is not a material of the {kind}{hint}"
            error(f"{where}plies/material", text)
    check_materials(owner, where, error)


def check_materials(owner: OfMaterials, where: str, error: Reporter) -> None:
    """Report unusable strengths; `where` starts the path.

    Parameters
    ----------
    owner : object with materials
    where : begin of the path of the dataset, for messages
    error : function that gets path and text of a finding
    """
    try:
        strengths(owner)
    except MaterialError as cause:
        error(f"{where}materials", str(cause))


def check_recovery(recovery: SectionRecovery, where: str, error: Reporter) -> None:
    """Report finite numbers of a recovery that cannot be used; `where` starts their path.

    Parameters
    ----------
    recovery : recovery data of a section
    where : begin of the path of the dataset, for messages
    error : function that gets path and text of a finding
    """
    rows_of(f"{where}recovery/ply", recovery.ply, len(recovery.plies), error)
    rotations(f"{where}recovery/A_BM", recovery.A_BM, error)
    for row, C_M in enumerate(recovery.C_M):
        symmetric(f"{where}plies/C_M[{row}]", C_M, error)
        positive_definite(f"{where}plies/C_M[{row}]", C_M, error)
    if not np.sum(recovery.weights) > 0.0:
        text = f"expected an area above 0, found {np.sum(recovery.weights):g} m2"
        error(f"{where}recovery/weights", text)
    check_plies(recovery, "section", where, error)


def unit_stress(recovery: SectionRecovery) -> Array:
    """Stress of every integration point in section axes, per unit resultant.

    Returns
    -------
    (p, 6, 6) [Pa/N, Pa/(N m)]: rows 11, 22, 33, 23, 13, 12, a column for each resultant
    """
    stress_M = recovery.C_M[recovery.ply] @ recovery.strain_M
    return np.asarray(bond(recovery.A_BM) @ stress_M)


def cell_means(section: "SectionFile", values: Array) -> Array:
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

    Parameters
    ----------
    path : path of the dataset, for messages
    K : stiffness of the section (6, 6)
    recovery : recovery data of the section
    limit : largest relative error
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
    along = (recovery.weights * r2)[:, None, None] * bond(recovery.A_BM)[:, :1]  # the axial stress
    return np.asarray((along @ recovery.C_M[recovery.ply] @ recovery.strain_M).sum(axis=0)[0])


MIDDLES = (22, 23, 28)  # VTK's cells with nodes in the middle of their sides, behind the corners
ANGLE_DEG = 195.0  # inside the material, above which a corner counts
WHOLE_DEG = 359.0  # above it a node lies inside the material


def reentrant_corners(mesh: "SectionMeshData") -> tuple[IntArray, Array]:
    """Nodes (k,) on the boundary with more than 195 deg of material around them.

    Returns
    -------
    nodes, and the size of the largest cell at each, (k,) [m]
    """
    around, size = np.zeros(len(mesh.nodes)), np.zeros(len(mesh.nodes))
    for kind in distinct(mesh.cell_types):
        rows = np.flatnonzero(mesh.cell_types == kind)
        first, last = mesh.offsets[rows[0]], mesh.offsets[rows[0] + 1]
        table = mesh.connectivity[mesh.offsets[rows][:, None] + np.arange(last - first)]
        n = CORNERS[int(kind)]
        corners = mesh.nodes[table[:, :n]]
        after, before = np.roll(corners, -1, axis=1), np.roll(corners, 1, axis=1)
        forth, back = after - corners, before - corners
        if int(kind) in MIDDLES:  # tangents of the parabolas
            middle = mesh.nodes[table[:, n : 2 * n]]
            forth = 4.0 * middle - 3.0 * corners - after
            back = 4.0 * np.roll(middle, 1, axis=1) - 3.0 * corners - before
        cross = forth[..., 0] * back[..., 1] - forth[..., 1] * back[..., 0]
        angle = np.abs(np.arctan2(cross, (forth * back).sum(axis=-1)))
        np.add.at(around, table[:, :n], angle)
        reach = np.linalg.norm(after - corners, axis=-1).max(axis=1)
        np.maximum.at(size, table[:, :n], reach[:, None])
    reentrant = np.flatnonzero((around > np.radians(ANGLE_DEG)) & (around < np.radians(WHOLE_DEG)))
    return reentrant, size[reentrant]


def near_corner(mesh: "SectionMeshData", points: Array, distance: float) -> NDArray[np.bool_]:
    """True for points (p, 2) nearer than `distance` [m] to a re-entrant corner, (p,).

    Parameters
    ----------
    mesh : mesh of the section
    points : points (p, 2) [m]
    distance : distance [m]
    """
    corners, _ = reentrant_corners(mesh)
    near = np.zeros(len(points), dtype=bool)
    for place in mesh.nodes[corners]:
        near |= np.linalg.norm(points - place, axis=1) < distance
    return near
