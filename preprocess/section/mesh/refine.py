"""Refinement of chosen cells: each is divided into four; corners of small cells may hang on large
edges."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....solver.math.arrays import Array
from ...fenicsx import EDGES, NODES
from .cells import ABSENT, CORNERS, FULL, KINDS, MOST_NODES, CellMesh, IntArray, full_basis

Edge = tuple[int, int]

# Places of the nodes on the reference cell whose corners children have, and these corners: corners
# of the parent, middles of its edges, centre.
PLACES = (NODES["triangle"] / 2.0, NODES["quadrilateral"] / 2.0)
CHILDREN = (
    np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]),
    np.array([[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]]),
)


def refined(mesh: CellMesh, marked: NDArray[np.bool_]) -> CellMesh:
    """The mesh with the marked cells (c,) divided into four, and as many others as this requires.

    The map of the parent gives new nodes, so that the shape does not change. Cells on both sides of
    an edge differ by one division at most.
    """
    marked = _with_neighbours(mesh, marked)
    work = _Division(mesh, marked)
    return work.divided()


def _edges(mesh: CellMesh, cell: int) -> list[Edge]:
    kind = int(mesh.kind[cell])
    corners = mesh.nodes[cell]
    return [_key(corners[a], corners[b]) for a, b in EDGES[KINDS[kind]]]


def _key(a: int, b: int) -> Edge:
    return (int(a), int(b)) if a < b else (int(b), int(a))


def _with_neighbours(mesh: CellMesh, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells with an edge on which a marked cell hangs are marked too."""
    if not len(mesh.hanging):
        return marked
    half = {}
    for a, b, m in mesh.hanging.tolist():
        half[_key(a, m)] = half[_key(m, b)] = _key(a, b)
    owner: dict[Edge, int] = {}
    cells, first, second = mesh.edge_table
    whole = set(half.values())
    for cell, a, b in zip(cells.tolist(), first.tolist(), second.tolist(), strict=True):
        if _key(a, b) in whole:
            owner[_key(a, b)] = cell
    marked = marked.copy()
    waiting = np.flatnonzero(marked).tolist()
    while waiting:
        cell = waiting.pop()
        for edge in _edges(mesh, cell):
            other = owner.get(half.get(edge, (-1, -1)), -1)
            if other >= 0 and not marked[other]:
                marked[other] = True
                waiting.append(other)
    return marked


class _Division:
    """New points and cells of one refinement."""

    def __init__(self, mesh: CellMesh, marked: NDArray[np.bool_]) -> None:
        self.mesh, self.marked = mesh, marked
        self.linear = mesh.degree == 1
        self.points: list[Array] = []
        self.n = len(mesh.points)
        self.middle: dict[Edge, int] = {}  # node in the middle of an edge
        for kind, rows in mesh.of_kinds:
            corners = CORNERS[kind]
            for side, (a, b) in enumerate(EDGES[KINDS[kind]]):
                nodes = mesh.nodes[rows]
                known = nodes[:, corners + side] >= 0
                for p, q, m in nodes[known][:, [a, b, corners + side]].tolist():
                    self.middle[_key(p, q)] = m
        for a, b, m in mesh.hanging.tolist():
            self.middle[_key(a, b)] = m
        self.split: dict[Edge, int] = {_key(a, b): m for a, b, m in mesh.hanging.tolist()}

    def divided(self) -> CellMesh:
        mesh = self.mesh
        nodes, kinds, regions, angles = [], [], [], []
        for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
            chosen = self.marked[rows]
            cells = rows[chosen]
            if not len(cells):
                continue
            nodes.append(self._children(kind, cells, shape[chosen]))
            kinds.append(np.full(4 * len(cells), kind))
            regions.append(np.repeat(mesh.region[cells], 4))
            if mesh.layer_angle is not None:
                angles.append(self._angles(kind, mesh.layer_angle[cells]))
        kept = ~self.marked
        new = CellMesh(
            np.concatenate([mesh.points, *self.points]),
            np.concatenate([mesh.nodes[kept], *nodes]),
            np.concatenate([mesh.kind[kept], *kinds]),
            np.concatenate([mesh.region[kept], *regions]),
            mesh.regions,
            layer_angle=None
            if mesh.layer_angle is None
            else np.concatenate([mesh.layer_angle[kept], *angles]),
        )
        _, first, second = new.edge_table
        left = {_key(a, b) for a, b in zip(first.tolist(), second.tolist(), strict=True)}
        hanging = [(*edge, m) for edge, m in self.split.items() if edge in left]
        return replace(new, hanging=np.array(hanging, dtype=np.int64).reshape(-1, 3))

    def _node(self, place: Array) -> int:
        self.points.append(place[None])
        self.n += 1
        return self.n - 1

    def _middle(self, a: int, b: int, place: Array) -> int:
        edge = _key(a, b)
        if edge not in self.middle:
            self.middle[edge] = self._node(place)
        return self.middle[edge]

    def _children(self, kind: int, cells: IntArray, shape: Array) -> IntArray:
        corners, full = CORNERS[kind], FULL[kind]
        edges = EDGES[KINDS[kind]]
        reference = _child_places(kind)  # (4, full, 2)
        places = (full_basis(kind, reference.reshape(-1, 2))[0] @ shape).reshape(
            len(cells), 4, full, 2
        )
        whole = full_basis(kind, PLACES[kind])[0] @ shape
        out = np.full((len(cells), 4, MOST_NODES), ABSENT)
        for i, cell in enumerate(cells.tolist()):
            parent = self.mesh.nodes[cell]
            local = np.full(full, ABSENT)
            local[:corners] = parent[:corners]
            for side, (a, b) in enumerate(edges):
                m = self._middle(parent[a], parent[b], whole[i, corners + side])
                self.split[_key(parent[a], parent[b])] = m
                local[corners + side] = m
            if full == 9:
                local[8] = parent[8] if parent[8] >= 0 else self._node(whole[i, 8])
            for j, child in enumerate(CHILDREN[kind]):
                own = local[child]
                out[i, j, :corners] = own
                if self.linear:
                    continue
                for side, (a, b) in enumerate(edges):
                    out[i, j, corners + side] = self._middle(
                        own[a], own[b], places[i, j, corners + side]
                    )
                if full == 9:
                    out[i, j, 8] = self._node(places[i, j, 8])
        return out.reshape(-1, MOST_NODES)

    @staticmethod
    def _angles(kind: int, angles: Array) -> Array:
        """Layer angles of the children: those of the parent at their nodes."""
        if angles.shape[1] == 1:
            return np.repeat(angles, 4, axis=0)
        full = FULL[kind]
        values = full_basis(kind, _child_places(kind).reshape(-1, 2))[0] @ angles[:, :full, None]
        out = np.zeros((len(angles) * 4, MOST_NODES))
        out[:, :full] = values.reshape(-1, full)
        return out


def _child_places(kind: int) -> Array:
    """Positions of all nodes of the children on the reference cell, (4, 6 or 9, 2)."""
    out = []
    for child in CHILDREN[kind]:
        corners = PLACES[kind][child]
        middles = [0.5 * (corners[a] + corners[b]) for a, b in EDGES[KINDS[kind]]]
        centre = [corners.mean(axis=0)] if FULL[kind] == 9 else []
        out.append(np.array([*corners, *middles, *centre]))
    return np.array(out)
