"""Negative eigenvalues of sparse matrices of a mesh, counted front by front."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from samples.exchange_samples import bar

from plymotion.preprocess.exchange.direct import Direct, dissection, negative_eigenvalues, order_of
from plymotion.solver.math.arrays import Array


def held_bar() -> tuple[sp.csr_matrix, sp.csr_matrix, Array]:
    """K and M of the arm held at one end, and the places of its dofs."""
    body = bar()
    places = np.repeat(body.nodes, 3, axis=0)
    free = np.flatnonzero(places[:, 0] > 1e-9)
    return body.K[free][:, free], body.M[free][:, free], places[free]


def test_count_is_that_of_the_eigenvalues() -> None:
    """At values over the whole spectrum, in fronts with and without negative pivots."""
    K, M, places = held_bar()
    parts = dissection(K, places)
    assert len(parts) > 5
    assert sorted(order_of(parts)) == list(range(len(places)))
    values = scipy.linalg.eigh(K.toarray(), M.toarray(), eigvals_only=True)
    for count in (0, 1, 5, 50, 300, len(values) - 3):
        low = values[count - 1] if count else 0.0
        middle = 0.5 * (low + values[count])
        assert negative_eigenvalues(sp.csr_matrix(K - middle * M), parts) == count


def test_parts_without_dofs_of_their_own() -> None:
    """Two springs that nothing connects, and an order that makes an empty separator."""
    n = 400
    A = sp.csr_matrix(sp.diags(np.where(np.arange(n) % 7 == 0, -1.0, 2.0)))
    places = np.column_stack([np.arange(n), np.zeros(n), np.zeros(n)]).astype(float)
    parts = dissection(A, places)
    assert any(len(part.rows) == 0 for part in parts)
    assert negative_eigenvalues(A, parts) == len(range(0, n, 7))


def test_a_singular_front_is_no_count() -> None:
    A = sp.csr_matrix(np.array([[1.0, 1.0], [1.0, 1.0]]))
    with pytest.raises(ArithmeticError, match="singular"):
        negative_eigenvalues(A, dissection(A, np.eye(2, 3)))


def test_the_count_leaves_the_factors_alone() -> None:
    """Static shapes take up the factors of the vibrations: one factorisation of K."""
    K, M, places = held_bar()
    direct = Direct(places)
    values, _ = direct.eigenpairs(K, M, 6)
    before = direct._last
    assert direct.negative_pivots(K - 0.5 * (values[3] + values[4]) * M) == 4
    X = direct.solve(K, np.ones((K.shape[0], 1)))
    assert direct._last is before
    assert np.abs(K @ X - 1.0).max() < 1e-6
