"""Membranes: pure bending in the plane, and the optimal triangle by a second route."""

import numpy as np
import pytest
from samples.shell_element_samples import (
    MEMBRANES,
    coupled,
    element_stiffness,
    isotropic,
    one_triangle,
    part_stiffness,
)

from plymotion.preprocess.shell.elements.membranes.opt import best_beta0
from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.elements.single_cells import element_strains
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles


def bending_ratio(membrane: str, nu: float, aspect: float, beta0: float | str) -> float:
    """Energy of two triangles at the nodal values of pure bending, over the exact energy."""
    a, b, h = aspect, 1.0, 0.1
    xy = 0.5 * np.array([[-a, -b], [a, -b], [a, b], [-a, b]])
    cells = np.array([[0, 1, 2], [0, 2, 3]])
    t = triangles(np.pad(xy, ((0, 0), (0, 1))), cells, np.array([1.0, 0, 0]))
    K = part_stiffness(t, isotropic(h, nu), "membrane", membrane, beta0)
    x, y = xy.T
    zero = np.zeros(4)
    u = np.stack([-x * y, 0.5 * (x**2 + nu * y**2), zero, zero, zero, x], axis=1)
    u = u[cells].reshape(2, 18)
    return float(np.einsum("ci,cij,cj", u, K, u) / (a * h * b**3 / 12.0))


@pytest.mark.parametrize("aspect", [0.5, 1, 2, 8])
@pytest.mark.parametrize("nu", [0.0, 0.25, 0.3, 0.45])
def test_opt_bends_exactly(nu, aspect) -> None:
    assert bending_ratio("opt", nu, aspect, "felippa") == pytest.approx(1.0, abs=1e-12)


def test_default_beta0_is_exact_without_lateral_contraction() -> None:
    assert bending_ratio("opt", 0.0, 4.0, Choice().beta0) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("nu", "ratios"), [(0.0, (4.5, 9.0, 99.0)), (0.25, (4.4, 8.0, 80.0)), (0.3, (4.45, 7.91, 77.1))]
)
def test_cst_locks(nu, ratios) -> None:
    for aspect, ratio in zip((1, 2, 8), ratios, strict=True):
        assert bending_ratio("cst", nu, aspect, 0.5) == pytest.approx(ratio, rel=2e-3)


@pytest.mark.parametrize(
    ("nu", "ratios"),
    [(0.0, (1.75, 2.5, 17.5)), (0.25, (1.8, 2.4, 14.4)), (0.3, (1.84, 2.42, 14.0))],
)
def test_allman_is_between(nu, ratios) -> None:
    # The stiffness of its spurious mode adds little: 2 % in the longest of these cells.
    for aspect, ratio in zip((1, 2, 8), ratios, strict=True):
        assert (1.0 - 4e-3) * ratio < bending_ratio("allman", nu, aspect, 0.5) < 1.024 * ratio


def test_best_beta0_of_an_isotropic_material() -> None:
    for nu in (0.0, 0.2, 0.3, 0.45):
        assert best_beta0(isotropic(0.3, nu).A[None])[0] == pytest.approx((1 - 4 * nu**2) / 2)


def test_best_beta0_has_a_floor() -> None:
    # A ply of carbon fibre, for which the mean over the directions makes no sense any more.
    E1, E2, G, nu = 142.0, 9.79, 6.0, 0.42
    s = 1 - nu**2 * E2 / E1
    A = np.array([[E1 / s, nu * E2 / s, 0], [nu * E2 / s, E2 / s, 0], [0, 0, G]])
    assert best_beta0(A[None])[0] == 0.01


def test_best_beta0_does_not_depend_on_the_axes() -> None:
    A = coupled(0.1).A
    c, s = np.cos(0.7), np.sin(0.7)
    T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [0, 0, c * c - s * s]])
    T[2, :2] = -2 * c * s, 2 * c * s
    assert best_beta0((T.T @ A @ T)[None])[0] == pytest.approx(best_beta0(A[None])[0], rel=1e-12)


@pytest.mark.parametrize("laminate", [isotropic(0.1), coupled(0.1)], ids=["plain", "coupled"])
def test_opt_by_its_natural_strains(laminate) -> None:
    # Felippa's way: strains along the sides, turned into Cartesian ones by an inverse matrix.
    t, _, _ = one_triangle()
    (x, y), S, A = t.xy_E[0].T, float(t.area[0]), laminate.A
    beta0, L = 0.37, t.length[0]
    Lm = np.zeros((9, 3))
    T = np.zeros((3, 9))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        y_jk, x_kj = y[j] - y[k], x[k] - x[j]
        Lm[3 * i] = 0.5 * np.array([y_jk, 0, x_kj])
        Lm[3 * i + 1] = 0.5 * np.array([0, x_kj, y_jk])
        y_ik, y_ji, x_ki, x_ij = y[i] - y[k], y[j] - y[i], x[k] - x[i], x[i] - x[j]
        Lm[3 * i + 2] = 0.75 * np.array(
            [y_jk * (y_ik - y_ji) / 6, x_kj * (x_ki - x_ij) / 6, (x_ki * y_ik - x_ij * y_ji) / 3]
        )
        T[:, 3 * i], T[:, 3 * i + 1] = x_kj / (4 * S), -y_jk / (4 * S)
        T[i, 3 * i + 2] += 1.0
    b = np.array([1, 2, 1, 0, 1, -1, -1, -1, -2])
    orders = ([1, 2, 3, 4, 5, 6, 7, 8, 9], [9, 7, 8, 3, 1, 2, 6, 4, 5], [5, 6, 4, 8, 9, 7, 2, 3, 1])
    corners = [
        2 * S / 3 * b[np.array(order) - 1].reshape(3, 3) / L[:, None] ** 2 for order in orders
    ]
    C, D = t.tangent[0].T
    natural = np.linalg.inv(np.stack([C * C, D * D, C * D], axis=1))
    E = natural.T @ A @ natural
    sides = [0.5 * (corners[i] + corners[j]) for i, j in ((0, 1), (1, 2), (2, 0))]
    higher = 0.75 * beta0 * S * sum(Q.T @ E @ Q for Q in sides)
    expected = Lm @ A @ Lm.T / S + T.T @ higher @ T
    found = part_stiffness(t, laminate, "membrane", "opt", beta0)[0]
    own = np.add.outer(6 * np.arange(3), [0, 1, 5]).ravel()
    found = found[np.ix_(own, own)]
    assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()


def test_coupling_acts_through_the_mean_strain() -> None:
    # Paper: Eq. (25): with B alone the energy is area e' B k of the mean strains.
    t, _, _ = one_triangle()
    laminate = coupled(0.1)
    u = np.random.default_rng(1).normal(size=18)
    for membrane in MEMBRANES:
        choice = Choice(membrane=membrane)
        with_B = element_stiffness(t, laminate, choice)[0]
        without = element_stiffness(t, laminate._replace(B=np.zeros((3, 3))), choice)[0]
        mean = element_strains(t, laminate, choice, u[None, :, None])[0, :, 0]
        energy = 2 * t.area[0] * mean[:3] @ laminate.B @ mean[3:6]
        assert u @ (with_B - without) @ u == pytest.approx(energy, rel=1e-11)
