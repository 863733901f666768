"""Numbers of the nodes of continuous Lagrange functions on a mesh of triangles and quadrilaterals.

Corners come first, then the nodes inside edges, then those inside cells.
"""

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array
from ... import fenicsx
from ...fenicsx import EDGES, NODES
from .cells import CORNERS, KINDS, CellMesh, IntArray

NEAR = 1e-9  # of the reference cell


class Numbering:
    """Nodes of each cell, and the values of nodes that neighbours determine.

    Attributes
    ----------
    n_node : number of nodes
    of_cells : for each kind in mesh.of_kinds, (c, k) nodes in the order of Basix
    """

    def __init__(self, mesh: CellMesh, degree: int) -> None:
        self.degree = degree
        self._vertex, compact = np.unique(
            np.concatenate([mesh.edge_table[1], mesh.edge_table[2], mesh.hanging.ravel()]),
            return_inverse=True,
        )
        e = len(mesh.edge_table[0])
        first, second = compact[:e], compact[e : 2 * e]
        self._hanging = compact[2 * e :].reshape(-1, 3)
        n_vertex = len(self._vertex)
        low, high = np.minimum(first, second), np.maximum(first, second)
        self._keys, edge = np.unique(low * n_vertex + high, return_inverse=True)
        self._n_vertex, n_edge = n_vertex, len(self._keys)
        inner = degree - 1  # nodes inside an edge
        total = n_vertex + n_edge * inner
        self.of_cells: list[IntArray] = []
        start = 0
        for kind, rows in mesh.of_kinds:
            sides = CORNERS[kind]
            some = slice(start, start + len(rows) * sides)
            start = some.stop
            corner = first[some].reshape(-1, sides)
            forward = (first < second)[some].reshape(-1, sides)
            edges = edge[some].reshape(-1, sides)
            places = fenicsx.reference_nodes(KINDS[kind], degree)
            nodes = np.full((len(rows), len(places)), -1)
            inside = []
            for local, place in enumerate(places):
                vertex, side, t = _where(kind, place)
                if vertex >= 0:
                    nodes[:, local] = corner[:, vertex]
                elif side >= 0:
                    row = _row(t, degree)
                    step = np.where(forward[:, side], row, inner - 1 - row)
                    nodes[:, local] = n_vertex + edges[:, side] * inner + step
                else:
                    inside.append(local)
            count = len(inside)
            own = total + np.arange(len(rows) * count).reshape(len(rows), count)
            nodes[:, inside] = own
            total += own.size
            self.of_cells.append(nodes)
        self.n_node = total

    def expansion(self) -> sp.csr_matrix | None:
        """Values of all nodes from the free ones, (n_node, n_free); None without hanging nodes.

        The values of nodes on half an edge follow from those of the whole edge.
        """
        if not len(self._hanging):
            return None
        p = self.degree
        inner = _inner(p)
        along = np.argsort(fenicsx.reference_nodes("interval", p)[:, 0])  # Basix: ends first
        matrix = sp.identity(self.n_node, format="lil")
        for a, b, m in self._hanging:
            lo, hi = min(a, b), max(a, b)
            masters = self._edge_nodes(lo, hi)
            rows, places = [int(m)], [0.5]
            for end, at in ((lo, 0.0), (hi, 1.0)):
                nodes = self._edge_nodes(min(end, m), max(end, m))[1:-1]
                # they are numbered from the end with the lower number
                local = at + (0.5 - at) * inner if end < m else 0.5 + (at - 0.5) * inner
                rows += nodes
                places += list(local)
            weights = fenicsx.lagrange("interval", p, np.array(places)[:, None])[0][:, along]
            for row, values in zip(rows, weights, strict=True):
                matrix.rows[row], matrix.data[row] = [], []
                for column, value in sorted(zip(masters, values, strict=True)):
                    if abs(value) > 1e-14:
                        matrix.rows[row].append(column)
                        matrix.data[row].append(float(value))
        P = matrix.tocsr()
        slaves = np.flatnonzero(np.asarray(P.diagonal()) == 0.0)
        while True:  # a master may be a slave of a still larger cell
            free = np.ones(self.n_node, dtype=bool)
            free[slaves] = False
            if not P[:, ~free].nnz:
                return P[:, free].tocsr()
            P = (P @ P).tocsr()

    def _edge_nodes(self, low: int, high: int) -> list[int]:
        """Nodes of an edge from its lower to its higher corner."""
        edge = int(np.searchsorted(self._keys, low * self._n_vertex + high))
        assert self._keys[edge] == low * self._n_vertex + high, "a hanging node without its edge"
        first = self._n_vertex + edge * (self.degree - 1)
        return [int(low), *range(first, first + self.degree - 1), int(high)]


def _where(kind: int, place: Array) -> tuple[int, int, float]:
    """Corner, or edge and position on it, of a node of the reference cell; -1 if neither."""
    corners = NODES[KINDS[kind]][: CORNERS[kind]] / 2.0
    near = np.flatnonzero(np.abs(corners - place).max(axis=1) < NEAR)
    if near.size:
        return int(near[0]), -1, 0.0
    for side, (a, b) in enumerate(EDGES[KINDS[kind]]):
        along, away = corners[b] - corners[a], place - corners[a]
        if abs(along[0] * away[1] - along[1] * away[0]) < NEAR:
            return -1, side, float(along @ away / (along @ along))
    return -1, -1, 0.0


def _inner(degree: int) -> Array:
    """Positions of the nodes inside an edge of length 1, ascending."""
    return np.asarray(np.sort(fenicsx.reference_nodes("interval", degree)[:, 0])[1:-1])


def _row(t: float, degree: int) -> int:
    return int(np.argmin(np.abs(_inner(degree) - t)))
