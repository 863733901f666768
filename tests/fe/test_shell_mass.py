"""Mass of shell triangles: rigid motions, the integral itself, the lumped form."""

import numpy as np
import pytest
from samples.shell_element_samples import element_mass, one_triangle, rigid_motions

from plymotion.preprocess.shell.shell_cells import POINTS
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles

MASS = np.array([2.0, 0.13, 0.05])  # offset: m1 is not zero


def exact_energies() -> np.ndarray:
    """(6, 6) integral of density times products of the velocities of six rigid motions."""
    t, points, _ = one_triangle()
    (m0, m1, m2), e3 = MASS, t.A_GE[0, :, 2]
    energies = np.zeros((6, 6))
    for weights in POINTS:
        r = weights @ points
        at_reference = np.hstack([np.eye(3), np.stack([np.cross(w, r) for w in np.eye(3)], axis=1)])
        per_height = np.hstack(
            [np.zeros((3, 3)), np.stack([np.cross(w, e3) for w in np.eye(3)], axis=1)]
        )
        cross = at_reference.T @ per_height
        energies += (
            m0 * at_reference.T @ at_reference
            + m1 * (cross + cross.T)
            + m2 * per_height.T @ per_height
        )
    return energies * t.area[0] / 3


def test_rigid_motions_have_their_exact_energy() -> None:
    # Paper: Eq. (20), Eq. (21), Eq. (22)
    t, points, _ = one_triangle()
    R = rigid_motions(points)
    M = element_mass(t, MASS)[0]
    expected = exact_energies()
    assert np.abs(R.T @ M @ R - expected).max() < 1e-14 * np.abs(expected).max()


def test_integral_by_numerical_quadrature() -> None:
    # Paper: Eq. (31): S'mS over the triangle, by Gauss points of a square laid onto it.
    t, _, _ = one_triangle()
    points, weights = np.polynomial.legendre.leggauss(4)
    points, weights = (points + 1) / 2, weights / 2
    m0, m1, m2 = MASS
    m = np.diag([m0, m0, m0, m2, m2, m2])
    m[0, 4] = m[4, 0] = m1
    m[1, 3] = m[3, 1] = -m1
    turn = np.zeros(18)  # (v,x - u,y)/2 of the linear displacements
    grad = np.linalg.inv(np.column_stack([t.xy_E[0], np.ones(3)]))[:2].T  # of area coordinates
    for i in range(3):
        turn[6 * i : 6 * i + 2] = -0.5 * grad[i, 1], 0.5 * grad[i, 0]
    expected = np.zeros((18, 18))
    for a, weight_a in zip(points, weights, strict=True):
        for b, weight_b in zip(points, weights, strict=True):
            area_coordinates = np.array([1 - a, a * (1 - b), a * b])
            S = np.kron(area_coordinates, np.eye(6))
            S[5] -= turn
            expected += weight_a * weight_b * a * 2 * t.area[0] * S.T @ m @ S
    R = np.kron(np.eye(6), t.A_GE[0])
    found = element_mass(t, MASS)[0]
    assert np.abs(found - R @ expected @ R.T).max() < 1e-14 * np.abs(expected).max()


@pytest.mark.parametrize("form", ["consistent", "lumped"])
def test_mass_and_static_moment_are_exact_and_the_matrix_definite(form) -> None:
    t, points, _ = one_triangle()
    R = rigid_motions(points)
    M = element_mass(t, MASS, form)[0]
    expected = exact_energies()
    found = R.T @ M @ R
    assert np.allclose(found[:3], expected[:3], atol=1e-14)
    assert np.linalg.eigvalsh(M).min() > 0
    assert np.abs(M - M.T).max() < 1e-16 * MASS[0] * t.area[0] * 10


def test_lumped_is_diagonal_about_the_middle() -> None:
    t, _, _ = one_triangle()
    M = element_mass(t, np.array([2.0, 0.0, 0.05]), "lumped")[0]
    third = t.area[0] / 3
    expected = np.diag(np.tile(third * np.repeat([2.0, 0.05], 3), 3))
    assert np.allclose(M, expected, atol=1e-16)


def test_lumped_corners_are_not_coupled() -> None:
    t, _, _ = one_triangle()
    M = element_mass(t, MASS, "lumped")[0].reshape(3, 6, 3, 6)
    M[range(3), :, range(3)] = 0.0
    assert not M.any()


def test_mass_of_each_triangle() -> None:
    points = np.random.default_rng(4).normal(size=(900, 3))
    t = triangles(points, np.arange(900).reshape(-1, 3), np.array([1.0, 2, 3]))
    each = np.where(np.arange(300)[:, None] % 2, MASS, 2 * MASS)
    M = element_mass(t, each)
    assert np.allclose(M[1::2], element_mass(t, MASS)[1::2], rtol=1e-14)
    assert np.allclose(M[::2], element_mass(t, 2 * MASS)[::2], rtol=1e-14)
