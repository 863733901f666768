"""The beam element: patch states, rigid motion, no locking, two routes to its stiffness."""

import numpy as np
import pytest
import scipy.integrate
from samples.beam_samples import straight_line

from plymotion.preprocess.beam.element import BeamElement, Q, Z, gauss
from plymotion.preprocess.beam.line import section_axes
from plymotion.solver.package.common.cells import node_positions


def coupled_stiffness() -> np.ndarray:
    """A positive definite 6x6 with every coupling, of a slender member's magnitudes."""
    A = np.random.default_rng(3).normal(size=(6, 6))
    scale = np.sqrt([2e6, 5e5, 4e5, 1.5, 1.3, 12.0])
    C = A @ A.T + 6.0 * np.eye(6)
    d = np.sqrt(np.diag(C))
    return C / np.outer(d, d) * np.outer(scale, scale)


K = coupled_stiffness()
LENGTH = 0.7


def exact_displacement(F0: np.ndarray, x: float) -> np.ndarray:
    """Clamped at 0: integrate d' = Z d + K^-1 F, F' = Q F numerically."""
    S = np.linalg.inv(K)

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([Z @ y[:6] + S @ y[6:], Q @ y[6:]])

    start = np.concatenate([np.zeros(6), F0])
    scale = np.abs(S).max() * np.abs(F0).max()
    run = scipy.integrate.solve_ivp(slope, (0, x), start, rtol=1e-12, atol=1e-14 * scale)
    return run.y[:6, -1]


@pytest.mark.parametrize("kind", range(6))
def test_patch_state_is_exact_on_an_irregular_mesh(kind: int) -> None:
    # One resultant at the free end: constant extension, twist, curvature and shear (the latter
    # with the moment that equilibrium demands).
    x = LENGTH * np.array([0.0, 0.13, 0.55, 1.0])
    line = straight_line(x, K, np.eye(6), np.eye(3))
    load = np.zeros(24)
    load[18 + kind] = 1.0
    stiffness = line.stiffness().toarray()
    d = np.zeros(24)
    d[6:] = np.linalg.solve(stiffness[6:, 6:], load[6:])
    end = np.zeros(6)
    end[kind] = 1.0
    F0 = (np.eye(6) - LENGTH * Q) @ end  # resultants at the clamp
    for node in (1, 2, 3):
        expected = exact_displacement(F0, x[node])
        assert np.allclose(
            d[6 * node : 6 * node + 6], expected, rtol=1e-9, atol=1e-9 * abs(d).max()
        )
    s = np.array([0.1])
    resultants = K @ BeamElement(x[2] - x[1], K).strain(s)[0] @ d[6:18]
    expected = (np.eye(6) + (x[1] + s[0]) * Q) @ F0
    assert np.allclose(resultants, expected, atol=1e-9)


def test_stiffness_by_flexibility_equals_the_integral() -> None:
    """Eq. (35): int B' K B dx."""
    element = BeamElement(0.21, K)
    x, w = gauss(element.length, 2)  # B' K B has degree 2 in x
    B = element.strain(x)
    a, b = element.stiffness(), np.einsum("k,kai,ab,kbj->ij", w, B, K, B)
    assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max()


def test_strain_is_the_derivative_of_the_shape() -> None:
    element = BeamElement(0.21, K)
    x, step = np.array([0.04, 0.11]), 1e-6
    slope = (element.shape(x + step) - element.shape(x - step)) / (2 * step)
    assert np.allclose(slope - Z @ element.shape(x), element.strain(x), atol=1e-6)


def test_shape_takes_the_nodal_values_at_the_nodes() -> None:
    ends = BeamElement(0.21, K).shape(np.array([0.0, 0.21]))
    assert np.abs(ends - np.eye(12).reshape(2, 6, 12)).max() < 1e-12


def test_rigid_motion_makes_no_force_and_no_strain() -> None:
    element = BeamElement(0.21, K)
    rigid = np.vstack([np.eye(6), np.eye(6) + 0.21 * Z])
    stiffness = element.stiffness()
    assert np.abs(stiffness @ rigid).max() < 1e-13 * np.abs(stiffness).max()
    assert (
        np.abs(element.strain(np.array([0.1]))[0] @ rigid).max()
        < 1e-12 * np.abs(element.strain(np.array([0.1]))).max()
    )
    assert np.linalg.matrix_rank(stiffness / np.abs(stiffness).max(), tol=1e-12) == 6


@pytest.mark.parametrize("elements", [1, 4])
def test_slender_limit_does_not_lock(elements: int) -> None:
    E, nu, h = 7e10, 0.3, 1.0
    length = 1e5 * h
    EA, EI, GA = E * h**2, E * h**4 / 12, E / (2 * (1 + nu)) * h**2 * 5 / 6
    section = np.diag([EA, GA, GA, 0.14 * GA * h**2, EI, EI])
    line = straight_line(np.linspace(0, length, elements + 1), section, np.eye(6), np.eye(3))
    stiffness = line.stiffness().toarray()[6:, 6:]
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    load = np.zeros(len(stiffness))
    load[-5] = 1.0
    d = scale * np.linalg.solve(stiffness * np.outer(scale, scale), scale * load)
    exact = length**3 / (3 * EI) + length / GA
    assert d[-5] == pytest.approx(exact, rel=1e-10)
    assert d[-1] == pytest.approx(length**2 / (2 * EI), rel=1e-10)


def test_stubby_limit_has_full_shear() -> None:
    section = np.diag([1e6, 3e5, 2e5, 10.0, 20.0, 30.0])
    stiffness = BeamElement(1e-3, section).stiffness()[6:, 6:]
    deflection = np.linalg.solve(stiffness, np.eye(6))[2, 2]
    assert deflection == pytest.approx(1e-3 / 2e5 + 1e-9 / (3 * 20.0), rel=1e-10)


def test_gauss_points_suffice_for_the_mass() -> None:
    element = BeamElement(0.21, K)
    mass = np.diag([0.06, 0.06, 0.06, 9e-7, 1e-7, 8e-7])
    x, w = gauss(0.21, 12)
    N = element.shape(x)
    fine = np.einsum("k,kai,ab,kbj->ij", w, N, mass, N)
    assert np.abs(fine - element.mass_matrix(mass, "consistent")).max() < 1e-13 * np.abs(fine).max()


def test_section_turned_by_90_degrees_swaps_the_planes() -> None:
    section, mass = np.diag([1e6, 3e5, 2e5, 10.0, 20.0, 30.0]), np.diag([1, 1, 1, 5e-3, 2e-3, 3e-3])
    x = np.linspace(0, 1, 4)
    straight = straight_line(x, section, mass, section_axes(np.array([0.0, 1.0, 0.0])))
    turned = straight_line(x, section, mass, section_axes(np.array([0.0, 0.0, 1.0])))
    y, z = 6 * 3 + 1, 6 * 3 + 2
    for a, b in (
        (straight.stiffness(), turned.stiffness()),
        (straight.mass_matrix("consistent"), turned.mass_matrix("consistent")),
    ):
        assert a[y, y] == pytest.approx(b[z, z], rel=1e-13)
        assert a[z, z] == pytest.approx(b[y, y], rel=1e-13)
        assert a[y, y] != pytest.approx(a[z, z], rel=1e-3)


@pytest.mark.parametrize("x2", [[1.0, 0, 0], [0, 2.0, 0], [0, 1.0], [0.1, 0.99, 0]])
def test_section_axis_must_be_a_unit_vector_across_the_beam(x2: list[float]) -> None:
    with pytest.raises(ValueError, match="unit vector"):
        section_axes(np.array(x2))


def test_every_stop_gets_a_node() -> None:
    assert np.allclose(node_positions(2.0, 16, [0.0, 0.5, 1.0]), np.linspace(0, 2, 17), atol=1e-15)
    x = node_positions(1.0, 16, [0.3, 0.77])
    assert len(x) == 17
    assert np.abs(x[:, None] - [0.3, 0.77]).min(axis=0).max() < 1e-15
    assert np.diff(x).max() / np.diff(x).min() < 1.5
    with pytest.raises(ValueError, match="at least 3"):
        node_positions(1.0, 2, [0.3, 0.77])
