"""Laminates of an imported shell, and the resultants of its modes for ply stresses.

The source gives plies and axes of its cells. Strains at the middle of a cell follow from the
displacements and rotations of its nodes, resultants from them by the laminate. No element of the
source is repeated: it has the same mean strains up to terms that vanish with its size.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...solver.errors import InputError
from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.schema import CellResultants, LaminateData
from ...solver.package.common.materials import MaterialError, material_from_dict
from ...solver.package.section.recovery_data import rounded
from ..laminate.spec import laminate_from_dict
from ..laminate.stiffness import LaminateError, laminate_stiffness

DENSITY, STRESS = ("rho",), ("E1", "E2", "E3", "G12", "G13", "G23", "E")


@dataclass(frozen=True)
class Cells:
    """Cells of a mesh, as in a modal package.

    Attributes
    ----------
    connectivity : (i,) rows of nodes, in the order of VTK
    offsets : (c + 1,)
    types : (c,) VTK cell types
    """

    connectivity: IntArray
    offsets: IntArray
    types: IntArray

    @staticmethod
    def of(cells: list[list[int]], types: list[int]) -> "Cells":
        """From lists of rows of nodes."""
        sizes = [0, *map(len, cells)]
        flat = [row for cell in cells for row in cell]
        return Cells(
            np.array(flat, dtype=np.int64),
            np.cumsum(sizes, dtype=np.int64),
            np.array(types, dtype=np.int64),
        )

    @staticmethod
    def points(count: int) -> "Cells":
        """One vertex per node, for a body without a mesh."""
        rows = np.arange(count, dtype=np.int64)
        return Cells(rows, np.arange(count + 1, dtype=np.int64), np.ones(count, dtype=np.int64))

    def each(self) -> list[tuple[int, IntArray]]:
        """Type and rows of nodes of every cell."""
        parts = np.split(self.connectivity, self.offsets[1:-1])
        return list(zip(self.types.tolist(), parts, strict=True))


class Recovered(NamedTuple):
    """What a package has for ply stresses."""

    laminates: tuple[LaminateData, ...]
    cells: CellResultants


@dataclass(frozen=True)
class Layups:
    """Laminates of e cells of a mesh.

    Attributes
    ----------
    materials : tables of constants by name (package/common/materials.py)
    laminates : tables of plies by name (preprocess/laminate/spec.py)
    cell : (e,) rows of the cells
    laminate : (e,) number of the laminate of each
    A_BE : (e, 3, 3) axes of the laminate: e3 the normal, e1 the direction of zero angle
    """

    materials: dict[str, dict[str, Any]]
    laminates: dict[str, dict[str, Any]]
    cell: IntArray
    laminate: IntArray
    A_BE: Array

    def in_units(self, length: float, mass: float, time: float) -> "Layups":
        """The same in SI; arguments: the size of the source's units in m, kg and s."""
        stress, density = mass / (length * time**2), mass / length**3
        materials = {}
        for name, table in self.materials.items():
            found = {k: v * stress if k in STRESS else v for k, v in table.items()}
            found["rho"] = table["rho"] * density
            if "strength" in table:
                found["strength"] = {k: v * stress for k, v in table["strength"].items()}
            materials[name] = found
        laminates = {}
        for name, table in self.laminates.items():
            plies = [{**ply, "thickness": ply["thickness"] * length} for ply in table["plies"]]
            laminates[name] = {**table, "plies": plies, "offset": table["offset"] * length}
        return replace(self, materials=materials, laminates=laminates)


def recovered(layups: Layups, nodes: Array, cells: Cells, shapes: Array, where: str) -> Recovered:
    """Return laminates, and the mean resultants of their cells per unit mode.

    Parameters
    ----------
    nodes : (n, 3) [m]
    shapes : (m, n, 6) displacements and rotations

    Raises
    ------
    InputError
        Constants or plies that are impossible.
    """
    try:
        materials = {k: material_from_dict(v, k) for k, v in layups.materials.items()}
        specs = {k: laminate_from_dict(v, materials, k) for k, v in layups.laminates.items()}
    except (LaminateError, MaterialError) as error:
        raise InputError(f"{where}: {error}") from error
    stiffness = {
        name: laminate_stiffness(spec.laminate, spec.shear) for name, spec in specs.items()
    }
    strains = centre_strains(layups, nodes, cells, shapes)
    found = np.empty_like(strains)
    for number, (A, B, D, Ds, *_) in enumerate(stiffness.values()):
        own = layups.laminate == number
        e, k, gamma = strains[own, :3], strains[own, 3:6], strains[own, 6:]
        found[own] = np.concatenate([A @ e + B @ k, B @ e + D @ k, Ds @ gamma], axis=1)
    data = (specs[name].data(name, stiffness[name], layups.materials) for name in specs)
    return Recovered(
        tuple(data),
        CellResultants(layups.cell, layups.laminate, layups.A_BE, rounded(found)),
    )


def centre_strains(layups: Layups, nodes: Array, cells: Cells, shapes: Array) -> Array:
    """Strains in the middle of triangles and quadrilaterals, in their axes, (e, 8, m).

    Order exx eyy gxy, kxx kyy kxy [1/m], gxz gyz, with u = u0 + z beta.
    """
    out = np.empty((len(layups.cell), 8, len(shapes)))
    rows = [cells.connectivity[cells.offsets[c] : cells.offsets[c + 1]] for c in layups.cell]
    for j, (own, A) in enumerate(zip(rows, layups.A_BE, strict=True)):
        slope = _slopes((nodes[own] - nodes[own].mean(axis=0)) @ A[:, :2])  # (2, k)
        u, turn = shapes[:, own, :3] @ A, shapes[:, own, 3:] @ A  # (m, k, 3)
        beta = np.stack([turn[..., 1], -turn[..., 0]], axis=-1)
        du, db = (np.einsum("ak,mkb->abm", slope, f) for f in (u, beta))  # d_a f_b
        mean = beta.mean(axis=1).T
        for first, d in ((0, du), (3, db)):
            out[j, first : first + 3] = d[0, 0], d[1, 1], d[1, 0] + d[0, 1]
        out[j, 6:] = du[:, 2] + mean
    return out


def _slopes(x: Array) -> Array:
    """Derivatives of the linear or bilinear functions of corners x (k, 2) at the middle, (2, k)."""
    if len(x) == 3:
        natural = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    else:
        natural = 0.25 * np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
    return np.asarray(np.linalg.solve(natural @ x, natural))
