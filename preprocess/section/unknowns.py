"""Unknowns of a section other than the displacements of its nodes."""

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array
from .cells import IntArray


class Unknowns:
    """Values of the nodes = P z, with unknowns z.

    Parameters
    ----------
    P : (n_node, n_unknown)
    R : (n_unknown, n_node) with R P = 1: the unknowns of values that the unknowns can take
    whole : (w,) unknowns that are the values of nodes `at` (w,)
    """

    def __init__(self, P: sp.csr_matrix, R: sp.csr_matrix, whole: IntArray, at: IntArray) -> None:
        self.P, self.R, self.whole, self.at = P.tocsr(), R.tocsr(), whole, at

    def of_nodes(self, nodal: Array) -> Array:
        """Unknowns (n_unknown, ...) of nodal values (n_node, ...)."""
        return np.asarray(self.R @ nodal.reshape(len(nodal), -1)).reshape(-1, *nodal.shape[1:])

    def at_nodes(self, z: Array) -> Array:
        """Nodal values (n_node, ...) of unknowns (n_unknown, ...)."""
        return np.asarray(self.P @ z.reshape(len(z), -1)).reshape(-1, *z.shape[1:])

    def then(self, others: "Unknowns") -> "Unknowns":
        """These unknowns as given by others."""
        return Unknowns(self.P @ others.P, others.R @ self.R, others.whole, self.at[others.at])

    def of_cells(self, dofs: IntArray) -> tuple[IntArray, Array]:
        """Unknowns of cells with nodes (c, k), as (c, m), and the part of P of each, (c, k, m).

        Cells with fewer unknowns repeat their first one with zeros.
        """
        c, k = dofs.shape
        picked = self.P[dofs.ravel()].tocoo()
        cell = picked.row // k
        key = cell.astype(np.int64) * self.P.shape[1] + picked.col
        unique, place = np.unique(key, return_inverse=True)
        owner = unique // self.P.shape[1]
        first = np.searchsorted(owner, np.arange(c))
        local = np.arange(len(unique)) - first[owner]
        m = int(local.max()) + 1
        table = np.repeat((unique[first] % self.P.shape[1])[:, None], m, axis=1)
        table[owner, local] = unique % self.P.shape[1]
        parts = np.zeros((c, k, m))
        parts[cell, picked.row % k, local[place.ravel()]] = picked.data
        return table, parts


def hanging_unknowns(P: sp.csr_matrix) -> Unknowns:
    """The unknowns of a mesh with hanging nodes: the values of all other nodes."""
    single = np.flatnonzero(np.diff(P.indptr) == 1)
    single = single[np.abs(P.data[P.indptr[single]] - 1.0) < 1e-12]
    columns, first = np.unique(P.indices[P.indptr[single]], return_index=True)
    n = P.shape[1]
    assert len(columns) == n, "an unknown without a node"
    at = single[first]
    R = sp.csr_matrix((np.ones(n), (np.arange(n), at)), shape=(n, P.shape[0]))
    return Unknowns(P, R, np.arange(n), at)
