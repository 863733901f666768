"""A body as another code describes it: by stiffness, mass and laminates of shells, or by modes.

The source gives plies and axes of its cells. Strains at the middle of a cell follow from the
displacements and rotations of its nodes, resultants from them by the laminate. No element of the
source is repeated: it has the same mean strains up to terms that vanish with its size.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ...solver.errors import InputError
from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import rigid_motions
from ...solver.package.body.package_schema import CellResultants, LaminateData
from ...solver.package.common.materials import MaterialError, material_from_dict
from ...solver.package.section.stress import rounded
from ..laminate.laminate_specification import laminate_from_dict
from ..laminate.stiffness import LaminateError, laminate_stiffness

CELLS_OF_SIZE = {1: 1, 2: 3, 3: 5, 4: 9, 8: 12}
# Number of corners -> derivatives of their functions by the natural coordinates at the middle.
NATURAL = {
    3: np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]),
    4: 0.25 * np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]]),
}
STRESS = ("E1", "E2", "E3", "G12", "G13", "G23", "E")


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
    laminates : tables of plies by name (preprocess/laminate/laminate_specification.py)
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
        """The same in SI.

        Parameters
        ----------
        length, mass, time : size of the source's units [m, kg, s]
        """
        stress, density = mass / (length * time**2), mass / length**3
        materials = {}
        for name, table in self.materials.items():
            converted = {k: v * stress if k in STRESS else v for k, v in table.items()}
            converted["rho"] = table["rho"] * density
            if "strength" in table:
                converted["strength"] = {k: v * stress for k, v in table["strength"].items()}
            materials[name] = converted
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
    resultants = np.empty_like(strains)
    for number, (A, B, D, Ds, *_) in enumerate(stiffness.values()):
        own = layups.laminate == number
        e, k, gamma = strains[own, :3], strains[own, 3:6], strains[own, 6:]
        resultants[own] = np.concatenate([A @ e + B @ k, B @ e + D @ k, Ds @ gamma], axis=1)
    data = (specs[name].data(name, stiffness[name], layups.materials) for name in specs)
    return Recovered(
        tuple(data), CellResultants(layups.cell, layups.laminate, layups.A_BE, rounded(resultants))
    )


def centre_strains(layups: Layups, nodes: Array, cells: Cells, shapes: Array) -> Array:
    """Strains in the middle of triangles and quadrilaterals, in their axes, (e, 8, m).

    Order exx eyy gxy, kxx kyy kxy [1/m], gxz gyz, with u = u0 + z beta.

    Parameters
    ----------
    layups : laminates of e cells, with their axes
    nodes : (n, 3) positions
    cells : of the mesh
    shapes : (m, n, 6) displacements and rotations, axes of the nodes
    """
    out = np.empty((len(layups.cell), 8, len(shapes)))
    rows = [cells.connectivity[cells.offsets[c] : cells.offsets[c + 1]] for c in layups.cell]
    for j, (own, A) in enumerate(zip(rows, layups.A_BE, strict=True)):
        # slopes of the linear or bilinear functions of the corners at the middle, (2, k)
        x, natural = (nodes[own] - nodes[own].mean(axis=0)) @ A[:, :2], NATURAL[len(own)]
        slope = np.linalg.solve(natural @ x, natural)
        u, turn = shapes[:, own, :3] @ A, shapes[:, own, 3:] @ A  # (m, k, 3)
        beta = np.stack([turn[..., 1], -turn[..., 0]], axis=-1)
        du, db = (np.einsum("ak,mkb->abm", slope, f) for f in (u, beta))  # d_a f_b
        mean = beta.mean(axis=1).T
        for first, d in ((0, du), (3, db)):
            out[j, first : first + 3] = d[0, 0], d[1, 1], d[1, 0] + d[0, 1]
        out[j, 6:] = du[:, 2] + mean
    return out


DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class FreeBody:
    """Matrices of a body that nothing holds; n nodes, N degrees of freedom.

    Attributes
    ----------
    where : file or object that messages name
    nodes : (n, 3) [length]
    node_ids : (n,) labels, unique
    cells : of the mesh
    K, M : (N, N) sparse, both triangles
    dof_node : (N,) row of the node
    dof_direction : (N,) 0 to 2 translation, 3 to 5 rotation, along and about the global axes
    groups : rows of nodes by name of a set in the source
    notes : facts about the source, for the provenance
    layups : laminates of cells, for ply stresses
    """

    where: str
    nodes: Array
    node_ids: IntArray
    cells: Cells
    K: sp.csr_matrix
    M: sp.csr_matrix
    dof_node: IntArray
    dof_direction: IntArray
    groups: dict[str, IntArray] = field(default_factory=dict)
    notes: dict[str, object] = field(default_factory=dict)
    layups: Layups | None = None

    def rigid_motions(self) -> Array:
        """Rigid motions in the dofs, (N, 6): along and about the axes through the origin."""
        return np.asarray(rigid_motions(self.nodes)[self.dof_node, self.dof_direction])

    def in_units(self, length: float, mass: float, time: float) -> "FreeBody":
        """The same body in SI.

        A translation is a length and a rotation is a number, so each row and column of a rotation
        has one more power of the length.

        Parameters
        ----------
        length, mass, time : size of the source's units [m, kg, s]
        """
        if length == mass == time == 1.0:
            return self  # no copies of large matrices
        arm = sp.diags(np.where(self.dof_direction < 3, 1.0, length))
        K, M = (sp.csr_matrix(arm @ A @ arm) for A in (self.K, self.M))
        layups = self.layups and self.layups.in_units(length, mass, time)
        nodes = self.nodes * length
        return replace(self, nodes=nodes, K=K * (mass / time**2), M=M * mass, layups=layups)

    def labels(self, dof: int) -> str:
        """Node and direction of a dof, for messages."""
        label = self.node_ids[self.dof_node[dof]]
        return f"node {label}, direction {DIRECTIONS[self.dof_direction[dof]]}"


@dataclass(frozen=True)
class ModalBody:
    """Modes of a source in its units; n nodes, m modes in ascending frequency.

    Attributes
    ----------
    shapes : (m, n, 6) displacements and rotations, any scale
    hertz : (m,) natural frequencies [1 / time]
    has_rotations : whether the source has rotations
    damping_ratios : (m,); None: zero
    mass : (n,); None: from the file `masses`
    """

    where: str
    nodes: Array
    node_ids: IntArray
    cells: Cells
    shapes: Array
    hertz: Array
    has_rotations: bool = False
    damping_ratios: Array | None = None
    mass: Array | None = None
    groups: dict[str, IntArray] = field(default_factory=dict)

    @property
    def dof_node(self) -> IntArray:
        """Nodes that move: all."""
        return np.arange(len(self.nodes))


def free_body(
    where: str,
    K: Any,
    M: Any,
    nodes: Array,
    ids: IntArray,
    dofs: IntArray,
    cells: Cells | None = None,
    **more: Any,
) -> FreeBody:
    """Body from matrices with labelled dofs.

    Nodes without a dof are kept for the mesh only if a cell has them.

    Parameters
    ----------
    where : file or object that messages name
    K, M : (N, N) dense or sparse, both triangles
    nodes : (n, 3) positions
    ids : (n,) labels of the nodes
    dofs : (N, 2) label of the node, direction 1 to 6
    cells : of the mesh; None: a point for each node
    more : other fields of the body

    Raises
    ------
    InputError
        Other directions or labels, or matrices of another size.
    """
    if not ((dofs[:, 1] >= 1) & (dofs[:, 1] <= 6)).all():
        wrong = dofs[(dofs[:, 1] < 1) | (dofs[:, 1] > 6)][0]
        raise InputError(
            f"{where}: dofs: node {wrong[0]}: direction {wrong[1]}, expected 1 to 6 (1 to 3 "
            "translations, 4 to 6 rotations)"
        )
    for name, A in (("stiffness", K), ("mass", M)):
        if A.shape != (len(dofs), len(dofs)):
            raise InputError(
                f"{where}: {name}: expected {len(dofs)} x {len(dofs)} for the {len(dofs)} degrees "
                f"of freedom, found {' x '.join(map(str, A.shape))}"
            )
    return FreeBody(
        where=where,
        nodes=nodes,
        node_ids=np.asarray(ids, dtype=np.int64),
        cells=cells or Cells.points(len(nodes)),
        K=sp.csr_matrix(K, dtype=float),
        M=sp.csr_matrix(M, dtype=float),
        dof_node=rows_of(dofs[:, 0], np.asarray(ids), where),
        dof_direction=np.asarray(dofs[:, 1] - 1, dtype=np.int64),
        **more,
    )


def labelled_cells(
    cells: Sequence[Sequence[int]] | None, types: Sequence[int] | None, ids: IntArray, where: str
) -> Cells | None:
    """Cells from the labels of their nodes; None without cells.

    Parameters
    ----------
    cells : labels of the nodes of each cell, in the order of VTK
    types : VTK types; None: by the number of nodes
    ids : (n,) labels of all nodes
    where : place for messages

    Raises
    ------
    InputError
        An unknown label, or a number of nodes that no type has.
    """
    if cells is None:
        return None
    if types is None:
        sizes = {len(cell) for cell in cells}
        if unknown := sizes - set(CELLS_OF_SIZE):
            raise InputError(
                f"{where}: cells: a cell has {min(unknown)} nodes; expected cell_types with it"
            )
        types = [CELLS_OF_SIZE[len(cell)] for cell in cells]
    rows = [rows_of(np.array(cell), ids, f"{where}: cells").tolist() for cell in cells]
    return Cells.of(rows, list(types))


def rows_of(labels: IntArray, known: IntArray, where: str) -> IntArray:
    """Rows of labels among the known ones.

    Parameters
    ----------
    labels : (k,) labels of nodes
    known : (n,) labels of all nodes, in any order
    where : place for messages

    Raises
    ------
    InputError
        An unknown label, the first of which it names.
    """
    order = np.argsort(known, kind="stable")
    at = np.searchsorted(known[order], labels).clip(max=len(known) - 1)
    rows = order[at]
    wrong = np.flatnonzero(known[rows] != labels)
    if len(wrong):
        raise InputError(f"{where}: no node has the label {labels[wrong[0]]}")
    return np.asarray(rows)
