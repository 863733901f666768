"""Interfaces of an imported body: groups of nodes that move as one, or whose mean is followed.

A face or an edge shares its area or length among its nodes as the diagonal of its mass matrix does:
all shares are positive, also those of the corners of a face with nodes on its sides.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ...solver.errors import InputError, nearest
from ...solver.math.arrays import Array, IntArray
from ...solver.math.rotations import vector_to_matrix
from ...solver.package.body.invariants import rigid_motions
from ...solver.package.common.cells import SOLID_FACES, corners_of
from .free_body import Cells, FreeBody, ModalBody
from .import_table import InterfaceTable

# VTK type -> faces, or edges of a flat cell: nodes at the corners, then on the sides.
_EDGES = {22: ((0, 1, 3), (1, 2, 4), (2, 0, 5)), 23: ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))}
FACES = SOLID_FACES | _EDGES
FACES |= {5: tuple(map(corners_of, _EDGES[22])), 9: tuple(map(corners_of, _EDGES[23]))}
# Number of nodes of a face or an edge -> share of each: corners, then sides.
SHARES = {
    2: (1 / 2, 1 / 2),
    3: (1 / 3, 1 / 3, 1 / 3),
    4: (1 / 4,) * 4,
    6: (3 / 57,) * 3 + (16 / 57,) * 3,
    8: (3 / 76,) * 4 + (16 / 76,) * 4,
}
EDGE = (1 / 6, 1 / 6, 4 / 6)
SPREAD = 1e-9  # smallest inertia of the points of a group relative to the largest


def _area_weights(nodes: Array, cells: Cells, rows: IntArray, where: str) -> Array:
    """Share of each of the nodes `rows` in the area (length) of the faces (edges) on them, sum 1.

    Raises InputError if no face of a cell lies on the nodes.
    """
    place = {int(row): k for k, row in enumerate(rows)}
    weights = np.zeros(len(rows))
    for kind, cell in cells.each():
        for face in FACES.get(kind, ()):
            own = [place.get(int(cell[k]), -1) for k in face]
            if min(own) < 0:
                continue
            edge = kind in (22, 23)
            points = nodes[cell[list(face)]][: 2 if edge else len(face)]
            weights[own] += face_area(points) * np.array(EDGE if edge else SHARES[len(face)])
    if not weights.sum() > 0.0:
        raise InputError(
            f'{where}.weights = "area": no face of a cell lies on these {len(rows)} nodes; '
            'expected a whole face, or weights = "equal"'
        )
    return np.asarray(weights / weights.sum())


def face_area(points: Array) -> float:
    """Area of a face by its corners; length of an edge of two nodes."""
    if len(points) == 2:
        return float(np.linalg.norm(points[1] - points[0]))
    corners = points[: {3: 3, 4: 4, 6: 3, 8: 4}[len(points)]]
    area = np.zeros(3)
    for one, two in pairwise(corners[1:]):
        area += np.cross(one - corners[0], two - corners[0]) / 2.0
    return float(np.linalg.norm(area))


@dataclass(frozen=True)
class Link:
    """One interface.

    Attributes
    ----------
    rows : (k,) nodes of the group
    weights : (k,) sum 1
    position : (3,) reference point [m]
    A_BI : (3, 3) interface axes in body axes
    motion : (6, N) motion of the reference point per displacement of the dofs, sparse
    """

    name: str
    rigid: bool
    rows: IntArray
    weights: Array
    position: Array
    A_BI: Array
    motion: sp.csr_matrix


class Constrained(NamedTuple):
    """Dofs after the rigid links.

    Attributes
    ----------
    T : (N, I) dofs of the body from the I independent ones, sparse
    places : (I, 3) where they are [m]
    rigid : (I, 6) rigid motions
    reference_dofs : name of a rigid interface -> its six independent dofs
    """

    T: sp.csr_matrix
    places: Array
    rigid: Array
    reference_dofs: dict[str, IntArray]


def links(body: FreeBody, tables: Mapping[str, InterfaceTable], length: float) -> list[Link]:
    """Interfaces in the order of `tables`.

    Parameters
    ----------
    tables : `InterfaceTable` by name, in the units of the source
    length : unit of the source [m]

    Raises
    ------
    InputError : no such nodes, a group without area or without rotations.
    """
    return [_link(body, name, table, length) for name, table in tables.items()]


def _link(body: FreeBody, name: str, table: InterfaceTable, length: float) -> Link:
    where = f"{body.where}: interfaces.{name}"
    rows = interface_rows(body, table, length, where)
    if table.get("weights", "equal") == "area":
        weights = _area_weights(body.nodes, body.cells, rows, where)
    else:
        weights = np.full(len(rows), 1.0 / len(rows))
    position = weights @ body.nodes[rows]
    if "position" in table:
        position = length * _three(table["position"], f"{where}.position")
    turn = _three(table.get("rotation_deg", [0.0, 0.0, 0.0]), f"{where}.rotation_deg")
    motion = _motion(body, rows, weights, position, where)
    A_BI = vector_to_matrix(np.deg2rad(turn))
    return Link(name, table["link"] == "rigid", rows, weights, position, A_BI, motion)


def _three(value: list[float], where: str) -> Array:
    if len(value) != 3:
        raise InputError(f"{where} = {value}: expected three numbers")
    return np.array(value, dtype=float)


def interface_rows(body: FreeBody | ModalBody, table: Any, length: float, where: str) -> IntArray:
    """Rows of the nodes of an interface, without those that have no dof.

    Parameters
    ----------
    body : in SI
    table : `InterfaceTable`, in the units of the source
    length : unit of the source [m]
    where : place in the file, for messages

    Raises
    ------
    InputError
        No such set or node; none or several ways to choose nodes.
    """
    given = [key for key in ("set", "nodes", "box") if key in table]
    if len(given) != 1:
        raise InputError(
            f"{where}: expected one of set, nodes, box; found {', '.join(given) or 'none'}"
        )
    if "set" in table:
        by_name = {group.upper(): rows for group, rows in body.groups.items()}
        if table["set"].upper() not in by_name:
            hint = nearest(table["set"], body.groups)
            raise InputError(f'{where}.set = "{table["set"]}": no such set of nodes{hint}')
        rows = by_name[table["set"].upper()]
    elif "nodes" in table:
        row_of = {int(label): row for row, label in enumerate(body.node_ids)}
        for label in table["nodes"]:
            if label not in row_of:
                raise InputError(f"{where}.nodes: no node has the label {label}")
        rows = np.array([row_of[label] for label in table["nodes"]], dtype=np.int64)
    else:
        if [len(corner) for corner in table["box"]] != [3, 3]:
            raise InputError(f"{where}.box = {table['box']}: expected two corners [x, y, z]")
        box = np.array(table["box"], dtype=float)
        inside = (body.nodes >= length * box.min(axis=0)) & (body.nodes <= length * box.max(axis=0))
        rows = np.flatnonzero(inside.all(axis=1))
    rows = np.unique(rows)[np.isin(np.unique(rows), body.dof_node)]
    if not len(rows):
        raise InputError(f"{where}: none of its nodes has a degree of freedom")
    return rows


def _motion(
    body: FreeBody, rows: IntArray, weights: Array, position: Array, where: str
) -> sp.csr_matrix:
    """Motion of the reference point that fits the nodes best: weighted least squares, (6, N).

    Translations alone, if they determine the motion. On a line, an edge of a shell, the rotations
    of the nodes count as well, over the radius of inertia of the line.
    """
    number = np.full((len(body.nodes), 6), -1)
    number[body.dof_node, body.dof_direction] = np.arange(len(body.dof_node))
    own = number[rows]  # (k, 6)
    R = rigid_motions(body.nodes[rows] - position)  # (k, 6, 6)
    centred = body.nodes[rows] - weights @ body.nodes[rows]
    inertia = np.einsum("k,ka,kb->ab", weights, centred, centred)
    values = np.linalg.eigvalsh(np.trace(inertia) * np.eye(3) - inertia)
    w = np.repeat(weights[:, None], 6, axis=1)
    w[:, 3:] = 0.0
    if not values[0] > SPREAD * max(values[-1], 1e-300):
        w[:, 3:] = np.where(own[:, 3:] >= 0, weights[:, None] * (np.trace(inertia) or 1.0), 0.0)
    normal = np.einsum("kd,kdi,kdj->ij", w, R, R)
    size = np.sqrt(np.diag(normal))
    size[size == 0.0] = 1.0
    if not np.linalg.eigvalsh(normal / np.outer(size, size))[0] > SPREAD:
        shape = "one node" if len(rows) == 1 else f"{len(rows)} nodes on one line"
        raise InputError(
            f"{where}: {shape} without usable rotations; expected a node with six degrees of "
            "freedom, or at least three nodes that are not on one line"
        )
    fit = np.linalg.solve(normal, np.einsum("kd,kdi->ikd", w, R).reshape(6, -1))
    used = np.flatnonzero(w.ravel() > 0.0)
    columns = np.tile(own.ravel()[used], 6)
    entries = (fit[:, used].ravel(), (np.repeat(range(6), len(used)), columns))
    return sp.csr_matrix(entries, (6, len(body.dof_node)))


def constrained(body: FreeBody, every: list[Link]) -> Constrained:
    """Eliminate the nodes of rigid interfaces: they move with their reference point.

    Raises InputError if two rigid interfaces share a node.
    """
    carrier = np.full(len(body.nodes), -1)
    rigid = [link for link in every if link.rigid]
    for i, link in enumerate(rigid):
        shared = link.rows[carrier[link.rows] >= 0]
        if len(shared):
            other = rigid[carrier[shared[0]]].name
            raise InputError(
                f"{body.where}: interfaces {other} and {link.name}: both rigid, and both have "
                f"node {body.node_ids[shared[0]]}; expected different nodes"
            )
        carrier[link.rows] = i
    loose = np.flatnonzero(carrier[body.dof_node] < 0)
    count = len(loose) + 6 * len(rigid)
    rows, columns, values = [loose], [np.arange(len(loose))], [np.ones(len(loose))]
    reference_dofs = {}
    for i, link in enumerate(rigid):
        dofs = np.flatnonzero(carrier[body.dof_node] == i)
        R = rigid_motions(body.nodes[body.dof_node[dofs]] - link.position)
        block = R[np.arange(len(dofs)), body.dof_direction[dofs]]  # (d, 6)
        own = len(loose) + 6 * i + np.arange(6)
        reference_dofs[link.name] = own
        rows.append(np.repeat(dofs, 6))
        columns.append(np.tile(own, len(dofs)))
        values.append(block.ravel())
    T = sp.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        (len(body.dof_node), count),
    )
    T.eliminate_zeros()
    points = np.array([link.position for link in rigid]).reshape(-1, 3)
    places = np.vstack([body.nodes[body.dof_node[loose]], np.repeat(points, 6, axis=0)])
    ends = rigid_motions(points).reshape(-1, 6)
    motions = np.vstack([body.rigid_motions()[loose], ends])
    return Constrained(T, places, motions, reference_dofs)
