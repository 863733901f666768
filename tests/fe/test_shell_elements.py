"""One shell element: its rigid modes, its limits, and that no frame or numbering is special."""

import itertools

import numpy as np
import pytest
from samples.shell_element_samples import (
    MEMBRANES,
    PLATES,
    coupled,
    element_stiffness,
    isotropic,
    one_triangle,
    part_stiffness,
    ratios,
    rigid_motions,
    turn,
)

from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.elements.single_cells import element_resultants, element_strains
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles

CELL = np.array([[0, 1, 2]])
COMPLETE = [("opt", "none"), ("allman", "none"), ("cst", "tie"), ("opt", "tie")]
EVERY = [(p, m, "auto") for p, m in itertools.product(PLATES, MEMBRANES)]


def scaled_eigenvalues(K: np.ndarray) -> np.ndarray:
    scale = 1.0 / np.sqrt(np.diag(K))
    return np.linalg.eigvalsh(K * np.outer(scale, scale))


@pytest.mark.parametrize(("membrane", "drilling"), COMPLETE)
@pytest.mark.parametrize("plate", PLATES)
@pytest.mark.parametrize("laminate", [isotropic(0.1), coupled(0.1)], ids=["plain", "coupled"])
def test_rigid_motions_alone_have_no_energy(laminate, plate, membrane, drilling) -> None:
    # Paper: Eq. (25), Eq. (26)
    t, points, _ = one_triangle()
    K = element_stiffness(t, laminate, Choice(plate, membrane, drilling=drilling))[0]
    assert np.abs(K @ rigid_motions(points)).max() < 1e-13 * np.abs(K).max()
    values = scaled_eigenvalues(K)
    assert np.abs(values[:6]).max() < 1e-13
    assert values[6] > 1e-8


def test_fictitious_drilling_keeps_one_mode_and_loses_one() -> None:
    # Its null vector is three equal rotations: free without motion, but held in a rigid turn.
    t, points, _ = one_triangle()
    choice = Choice(membrane="cst", drilling="fictitious", drilling_factor=0.1)
    K = element_stiffness(t, isotropic(0.1), choice)[0]
    equal = np.zeros((3, 6))
    equal[:, 3:] = t.A_GE[0, :, 2]
    assert np.abs(K @ equal.ravel()).max() < 1e-15 * np.abs(K).max()
    values = scaled_eigenvalues(K)
    assert (values < 1e-12).sum() == 7
    assert np.abs(K @ rigid_motions(points)).max() < 1e-13 * np.abs(K).max()


@pytest.mark.parametrize(("plate", "membrane", "drilling"), EVERY)
def test_turning_everything_turns_the_stiffness(plate, membrane, drilling) -> None:
    # Paper: Eq. (23)
    _, points, direction = one_triangle()
    choice = Choice(plate, membrane, drilling=drilling)
    A = turn(11)
    here = element_stiffness(triangles(points, CELL, direction), coupled(0.1), choice)[0]
    there = element_stiffness(triangles(points @ A.T, CELL, A @ direction), coupled(0.1), choice)[0]
    R = np.kron(np.eye(6), A)
    assert np.abs(there - R @ here @ R.T).max() < 1e-14 * np.abs(here).max()


@pytest.mark.one_end
@pytest.mark.parametrize("order", [(1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0)])
@pytest.mark.parametrize(("plate", "membrane", "drilling"), EVERY)
def test_no_corner_is_special(plate, membrane, drilling, order) -> None:
    # Against the sense of the first order the normal is reversed to keep the laminate's axes.
    _, points, direction = one_triangle()
    flip = order in {(0, 2, 1), (2, 1, 0)}
    choice = Choice(plate, membrane, drilling=drilling)
    first = triangles(points, CELL, direction)
    other = triangles(points, CELL[:, order], direction, flip)
    assert np.allclose(first.A_GE, other.A_GE, atol=1e-15)
    K = element_stiffness(first, coupled(0.1), choice)[0].reshape(3, 6, 3, 6)
    K_other = element_stiffness(other, coupled(0.1), choice)[0].reshape(3, 6, 3, 6)
    expected = K[order, :][:, :, order]
    assert np.abs(K_other - expected).max() < 1e-13 * np.abs(K).max()
    u = np.random.default_rng(0).normal(size=(1, 3, 6))
    moved = u[:, order].reshape(1, 18, 1)
    strains = element_strains(first, coupled(0.1), choice, u.reshape(1, 18, 1))
    assert np.allclose(element_strains(other, coupled(0.1), choice, moved), strains, atol=1e-12)


@pytest.mark.parametrize("plate", PLATES)
def test_isotropic_stiffness_does_not_know_the_reference_direction(plate) -> None:
    _, points, direction = one_triangle()
    one, other = (
        element_stiffness(triangles(points, CELL, d), isotropic(0.1), Choice(plate))
        for d in (direction, np.array([1.0, -0.3, 0.2]))
    )
    assert np.abs(one - other).max() < 1e-14 * np.abs(one).max()


def test_chunks_and_laminates_of_each_triangle() -> None:
    rng = np.random.default_rng(8)
    points, cells = rng.normal(size=(1500, 3)), np.arange(1500).reshape(-1, 3)
    t = triangles(points, cells, rng.normal(size=(500, 3)), rng.random(500) > 0.5)
    thin, thick = coupled(0.1), coupled(0.2)
    pick = rng.random(500) > 0.5
    each = type(thin)(
        *(np.where(pick[:, None, None], a, b) for a, b in zip(thin, thick, strict=True))
    )
    whole = element_stiffness(t, each, Choice())
    for laminate, some in ((thin, pick), (thick, ~pick)):
        assert np.allclose(whole[some], element_stiffness(t, laminate, Choice())[some], rtol=1e-14)
    assert np.abs(whole - whole.swapaxes(1, 2)).max() < 1e-15 * np.abs(whole).max()
    u = rng.normal(size=(500, 18, 2))
    forces = element_resultants(t, each, Choice(), u)
    assert np.allclose(forces[pick], element_resultants(t, thin, Choice(), u)[pick], rtol=1e-12)


@pytest.mark.parametrize("laminate", [isotropic(0.3), coupled(0.3)], ids=["plain", "coupled"])
@pytest.mark.parametrize("plate", ["dst", "dkmt"])
def test_rigid_shear_gives_dkt(plate, laminate) -> None:
    t, _, _ = one_triangle()
    stiff = laminate._replace(Ds=1e8 * laminate.Ds)
    kirchhoff, found = (part_stiffness(t, stiff, "plate", name) for name in ("dkt", plate))
    assert np.abs(found - kirchhoff).max() < 1e-6 * np.abs(kirchhoff).max()
    u = np.random.default_rng(2).normal(size=(1, 18, 1))
    T = element_resultants(t, stiff, Choice("dst"), u)[:, 6:]
    T_kirchhoff = element_resultants(t, laminate, Choice("dkt"), u)[:, 6:]
    assert np.allclose(T, T_kirchhoff, rtol=1e-6)


def test_soft_shear_gives_mitc3() -> None:
    t, _, _ = one_triangle()
    laminate = coupled(0.3)
    soft = laminate._replace(Ds=1e-10 * laminate.Ds)
    expected, found = (part_stiffness(t, soft, "plate", name) for name in ("mitc3", "dkmt"))
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_shear_ratio_of_an_isotropic_plate() -> None:
    t, _, _ = one_triangle()
    laminate, nu, h = isotropic(0.2), 0.3, 0.2
    expected = 2.0 / (5 / 6 * (1 - nu)) * (h / t.length) ** 2
    assert np.allclose(ratios(t, laminate), expected, rtol=1e-13)


def test_shear_ratio_is_of_the_direction_of_the_side() -> None:
    # Sides along e1 and e2 of a right triangle see D11 with Ds11 and D22 with Ds22.
    t = triangles(np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0]]), CELL, np.array([1.0, 0, 0]))
    D, Ds = np.diag([5.0, 7.0, 1.0]), np.diag([2.0, 3.0])
    phi = ratios(t, isotropic(1.0)._replace(D=D, Ds=Ds))[0]
    assert np.allclose(phi[[0, 2]], [12 * 5 / (2 * 4), 12 * 7 / (3 * 9)], rtol=1e-14)
