"""Modal package from the matrices of any code, in Python."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
import scipy.sparse as sp

from ...solver.errors import InputError
from ...solver.math.arrays import Array, IntArray
from ...solver.package import ModalPackage
from ...solver.package.common.table_form import SpecError, check_form
from .free_body import FreeBody
from .layups import Cells
from .reduce import Tell, reduce_body, rows_of
from .spec import SI, Reduction, UnitsTable

CELLS_OF_SIZE = {1: 1, 2: 3, 3: 5, 4: 9, 8: 12}


def from_matrices(
    M: Any,
    K: Any,
    nodes: Array,
    dofs: "Array | Sequence[Sequence[int]]",
    *,
    body: str,
    interfaces: Mapping[str, Any],
    reference: Mapping[str, Any],
    modes: Sequence[Mapping[str, Any]],
    units: UnitsTable = SI,
    node_ids: "IntArray | None" = None,
    cells: "Sequence[Sequence[int]] | None" = None,
    cell_types: "Sequence[int] | None" = None,
    total_mass: "float | None" = None,
    damping_ratio: float = 0.0,
    tell: Tell = lambda _: None,
) -> ModalPackage:
    """Reduce the mass and stiffness matrix of a free body to a modal package.

    Parameters
    ----------
    M, K : (N, N) matrices of the free body, dense or sparse, both triangles
    nodes : (n, 3) coordinates
    dofs : (N, 2) label of the node and direction (1 to 3 translations, 4 to 6 rotations) of each
        row of the matrices
    body : name
    interfaces, reference, modes : tables of an import file (docs/exchange.md)
    units : of length, mass and time of all arguments
    node_ids : (n,) labels of the nodes; absent: 1 to n
    cells : labels of the nodes of each cell, in the order of VTK; absent: points
    cell_types : VTK types; absent: by the number of nodes (2 line, 3 triangle, 4 quadrilateral,
        8 hexahedron)
    total_mass : mass to compare with [kg]
    damping_ratio : of every mode
    tell : called with the name of each step

    Raises
    ------
    InputError : the matrices are not those of one free body, or a request cannot be fulfilled.
    """
    where = "from_matrices"
    table: dict[str, Any] = {
        "body": body,
        "reference": dict(reference),
        "modes": [dict(mode) for mode in modes],
        "interfaces": {name: dict(entry) for name, entry in interfaces.items()},
        "units": dict(units),
        "damping_ratio": damping_ratio,
    }
    if total_mass is not None:
        table["total_mass"] = total_mass
    try:
        check_form(table, Reduction)
    except SpecError as error:
        raise InputError(f"{where}: {error}") from error
    points = np.asarray(nodes, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise InputError(f"{where}: nodes: expected an array (n, 3), found {points.shape}")
    ids = np.arange(1, len(points) + 1) if node_ids is None else np.asarray(node_ids)
    numbers = np.asarray(dofs)
    if numbers.ndim != 2 or numbers.shape[1] != 2:
        raise InputError(f"{where}: dofs: expected an array (N, 2), found {numbers.shape}")
    source = free_body(where, K, M, points, ids, numbers, _cells(cells, cell_types, ids, where))
    return reduce_body(source, cast(Reduction, table), tell)


def free_body(
    where: str,
    K: Any,
    M: Any,
    nodes: Array,
    ids: IntArray,
    dofs: IntArray,
    cells: "Cells | None" = None,
    **more: Any,
) -> FreeBody:
    """Body from matrices with dofs (N, 2): label of the node, direction 1 to 6.

    Nodes without a dof are kept for the mesh only if a cell has them.
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


def _cells(
    cells: "Sequence[Sequence[int]] | None",
    types: "Sequence[int] | None",
    ids: IntArray,
    where: str,
) -> "Cells | None":
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
