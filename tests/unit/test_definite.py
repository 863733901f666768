"""Positive definite or not: rounding may not decide, nor may units."""

import numpy as np
import pytest

from plymotion.solver.math.arrays import (
    is_positive_definite,
    quadratic_forms,
    smallest_eigenvalue,
    to_unit_diagonal,
)


def of_rank(rank: int, n: int, rng: np.random.Generator) -> np.ndarray:
    """Positive semi-definite, exact but for rounding, its rows in units of 1e-6 to 1e6."""
    A = rng.normal(size=(n, rank)) * 10.0 ** rng.uniform(-6.0, 6.0, size=n)[:, None]
    return A @ A.T


def test_singular_matrices_are_never_definite() -> None:
    rng = np.random.default_rng(1)
    matrices = [of_rank(n - 1, n, rng) for n in (2, 3, 6, 20, 60) for _ in range(40)]
    assert not any(is_positive_definite(A) for A in matrices)
    # the sign of the smallest eigenvalue alone would be a toss of a coin
    signs = {np.sign(np.linalg.eigvalsh(to_unit_diagonal(A))[0]) for A in matrices}
    assert {1.0, -1.0} <= signs


@pytest.mark.parametrize("n", [1, 2, 3, 6, 20, 60])
def test_regular_matrices_of_any_units_are_definite(n: int) -> None:
    rng = np.random.default_rng(n)
    assert all(is_positive_definite(of_rank(2 * n, n, rng)) for _ in range(40))
    assert is_positive_definite(np.diag(10.0 ** np.linspace(-150.0, 150.0, n)))


def test_small_but_definite() -> None:
    """A section whose axes are a thousand times its size away: 1e-6 of the scaled matrix."""
    extension, bending, distance = 1e6, 1.0, 1.0
    K = np.array(
        [
            [extension, extension * distance],
            [extension * distance, bending + extension * distance**2],
        ]
    )
    assert smallest_eigenvalue(K) == pytest.approx(0.5e-6, rel=1e-3)
    assert is_positive_definite(K)


def test_indefinite() -> None:
    assert smallest_eigenvalue(np.diag([4.0, -9.0])) == pytest.approx(-1.0)
    assert not is_positive_definite(np.array([[1.0, 1.1], [1.1, 1.0]]))
    assert not is_positive_definite(np.zeros((2, 2)))
    assert not is_positive_definite(np.diag([1.0, np.inf]))


def test_diagonal_that_is_rounding() -> None:
    """A diagonal entry far below its expected size counts as zero, whatever its sign."""
    for entry in (1e-17, 0.0, -1e-17):
        A = np.diag([1.0, entry])
        assert smallest_eigenvalue(A, np.array([1.0, 1.0])) == pytest.approx(entry, abs=1e-30)
    assert smallest_eigenvalue(np.diag([1.0, 1e-17])) == pytest.approx(1.0)


def test_quadratic_forms_of_rows() -> None:
    rng = np.random.default_rng(2)
    H, q = rng.normal(size=(3, 4, 4)), rng.normal(size=(5, 4))
    expected = [[row @ each @ row for each in H] for row in q]
    np.testing.assert_allclose(quadratic_forms(H, q), expected, atol=1e-13)
