"""Quadrilateral shell elements: patches, zero-energy modes, frames, mass, pairs of triangles."""

import numpy as np
import pytest
import ufl
from samples.shell_element_samples import (
    QUADS,
    coupled,
    element_mass,
    element_stiffness,
    isotropic,
    nodal,
    one_quadrilateral,
    quad_patch,
    quad_patch_error,
    rigid_motions,
    state,
    turn,
)

from plymotion.preprocess import fenicsx
from plymotion.preprocess.shell.elements.cell import SIZE, Cell
from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.elements.quadrilateral import relief
from plymotion.preprocess.shell.elements.single_cells import (
    cell_matrices,
    cell_table,
    element_resultants,
)
from plymotion.preprocess.shell.shell_cells import GAUSS, ShellError, width_ratios
from plymotion.preprocess.shell.shell_cells import cell_geometry as quadrilaterals
from plymotion.solver.package.common.cells import area_vectors, centres, corner_areas, sides

STRAIN, CURVATURE = np.array([1.0, -0.4, 0.7]), np.array([0.8, 1.0, -0.5])
NONE = np.zeros(3)
ROTATING = ("opt", "allman")
LAMINATES = [isotropic(0.1), coupled(0.1)]
NAMES = ["plain", "coupled"]
CELL = np.array([[0, 1, 2, 3]])


@pytest.mark.parametrize("membrane", ROTATING)
@pytest.mark.parametrize("quad", QUADS)
@pytest.mark.parametrize("laminate", LAMINATES, ids=NAMES)
def test_constant_strain_and_curvature(laminate, quad, membrane) -> None:
    choice = Choice(membrane=membrane, quadrilateral=quad)
    for e, k in ((STRAIN, NONE), (STRAIN, CURVATURE)):
        assert quad_patch_error(laminate, choice, e, k) < 1e-12
        assert quad_patch_error(laminate, choice, e, k, backwards=True) < 1e-12


@pytest.mark.parametrize("thickness", [1e-3, 0.1, 1.0])
@pytest.mark.parametrize("quad", QUADS)
def test_constant_curvature_at_any_thickness(quad, thickness) -> None:
    choice = Choice(quadrilateral=quad)
    assert quad_patch_error(isotropic(thickness), choice, NONE, CURVATURE, np.eye(3)) < 1e-12


@pytest.mark.parametrize("cut", [1, 2, 3])
@pytest.mark.parametrize("membrane", ROTATING)
@pytest.mark.parametrize("laminate", LAMINATES, ids=NAMES)
def test_patch_of_triangles_and_quadrilaterals(laminate, membrane, cut) -> None:
    choice = Choice(membrane=membrane)
    assert quad_patch_error(laminate, choice, STRAIN, CURVATURE, cut=cut) < 1e-12


def test_sides_that_bow_differently_fail_the_mixed_patch() -> None:
    # the hybrid membrane with the sides of opt beside allman, whose sides bow less
    opt, allman = (Choice(membrane=membrane) for membrane in ROTATING)
    for own, other in ((opt, allman), (allman, opt)):
        error = quad_patch_error(isotropic(0.1), own, STRAIN, NONE, cut=2, beside=other)
        assert error > 0.01


@pytest.mark.parametrize("warp", [0.0, 0.2])
@pytest.mark.parametrize("quad", QUADS)
@pytest.mark.parametrize("laminate", LAMINATES, ids=NAMES)
def test_rigid_motions_alone_have_no_energy(laminate, quad, warp) -> None:
    q, points = one_quadrilateral(warp)
    K = element_stiffness(q, laminate, Choice(quadrilateral=quad))[0]
    assert np.abs(K @ rigid_motions(points)).max() < 1e-13 * np.abs(K).max()
    scale = 1.0 / np.sqrt(np.diag(K))
    values = np.linalg.eigvalsh(K * np.outer(scale, scale))
    assert np.abs(values[:6]).max() < 1e-13
    assert values[6] > 1e-4


@pytest.mark.parametrize("warp", [0.0, 0.2])
@pytest.mark.parametrize("order", [(1, 2, 3, 0), (2, 3, 0, 1), (3, 2, 1, 0), (0, 3, 2, 1)])
def test_no_corner_and_no_frame_is_special(order, warp) -> None:
    _, points = one_quadrilateral(warp)
    direction, A = np.array([0.4, 1.0, -0.3]), turn(11)
    flip = order in {(3, 2, 1, 0), (0, 3, 2, 1)}
    first = quadrilaterals(points, CELL, direction)
    other = quadrilaterals(points @ A.T, CELL[:, order], A @ direction, flip)
    K, L = (
        element_stiffness(q, coupled(0.1), Choice())[0].reshape(4, 6, 4, 6) for q in (first, other)
    )
    R = np.kron(np.eye(2), A)
    expected = np.einsum("ab,ibjd,cd->iajc", R, K, R)[list(order)][:, :, list(order)]
    assert np.abs(L - expected).max() < 1e-13 * np.abs(K).max()


def test_resultants_of_a_constant_state() -> None:
    xy, cells = quad_patch()
    A_GE = turn(4)
    laminate = coupled(0.1)
    q = quadrilaterals(xy @ A_GE[:, :2].T, cells, A_GE[:, 0])
    u = nodal(state(xy, STRAIN, CURVATURE, A_GE), cells)
    found = element_resultants(q, laminate, Choice(), u)[:, :, 0]
    N = laminate.A @ STRAIN + laminate.B @ CURVATURE
    M = laminate.B @ STRAIN + laminate.D @ CURVATURE
    assert np.allclose(found, [*N, *M, 0.0, 0.0], rtol=1e-11, atol=1e-12 * abs(N).max())


@pytest.mark.parametrize("form", ["consistent", "lumped"])
def test_mass_of_rigid_translations(form) -> None:
    q, points = one_quadrilateral()
    R = rigid_motions(points)[:, :3]
    M = element_mass(q, np.array([2.0, 0.0, 0.05]), form)[0]
    assert np.allclose(R.T @ M @ R, 2.0 * q.area[0] * np.eye(3), rtol=1e-13, atol=1e-13)


def test_consistent_mass_of_rigid_rotations() -> None:
    q, points = one_quadrilateral()
    m = np.array([2.0, 0.13, 0.05])
    R = rigid_motions(points)[:, 3:]
    exact = np.zeros((3, 3))
    e3 = q.A_GE[0, :, 2]
    for N, weight in zip(q.interpolation, q.weight[0], strict=True):
        r = N @ points
        for height, share in ((0.0, m[0]), (1.0, m[1]), (-1.0, -m[1])):
            # moments of the density about the reference surface, by differences
            arm = r + height * e3
            exact += (
                0.5
                * (1.0 if height else 2.0)
                * weight
                * share
                * (arm @ arm * np.eye(3) - np.outer(arm, arm))
            )
        exact += weight * m[2] * (np.eye(3) - np.outer(e3, e3))
    M = element_mass(q, m)[0]
    assert np.abs(R.T @ M @ R - exact).max() < 1e-13 * np.abs(exact).max()


def test_cells_without_a_shape_are_refused() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0.1, 0.1, 0], [0, 1, 0], [1, 1, 0]])
    with pytest.raises(ShellError, match="180 degrees"):
        quadrilaterals(points, CELL, np.array([1.0, 0, 0]))
    crossed = np.array([[0, 1, 3, 4]])
    with pytest.raises(ShellError, match="has no area"):
        quadrilaterals(points, crossed, np.array([1.0, 0, 0]))
    with pytest.raises(ShellError, match="normal to its reference direction"):
        quadrilaterals(points, np.array([[0, 1, 4, 3]]), np.array([0.0, 0, 1.0]))


def test_internal_rotations_answer_to_shear_that_varies() -> None:
    q, _ = one_quadrilateral()
    laminate = coupled(0.5)._replace(B=np.zeros((3, 3)))
    symbols = fenicsx.symbols("quadrilateral", SIZE, 24)
    cell, one = Cell(symbols, 4), symbols.unknowns[0]
    shears = {"even": [1.0] * 4, "varying": GAUSS[:, 1].tolist()}  # gxz and gyz; gxz alone

    def relieved(name: str, D: np.ndarray) -> float:
        shear = [ufl.as_vector((a * one, a * one * (name == "even"))) for a in shears[name]]
        stress, strain = ([a[0] for a in rows] for rows in zip(*relief(cell, shear), strict=True))
        kernel = fenicsx.kernel(24, [fenicsx.compiled(SIZE, stress, strain)])
        table = cell_table(q, laminate._replace(D=D), Choice())
        return -cell_matrices(q, kernel, table)[0, 0, 0]

    size = laminate.Ds.max()
    assert abs(relieved("even", laminate.D)) < 1e-14 * size
    # of gxz = eta: at most the energy of its part along f, (8/15)^2 / (32/105)
    assert relieved("varying", 1e-9 * laminate.D) > 0.0
    assert relieved("varying", 1e9 * laminate.D) < 1e-6 * size


def test_one_ratio_from_both_sides_and_none_beside_triangles() -> None:
    points = np.array(
        [[0.0, 0, 0], [2, 0, 0], [4, 0, 0], [0, 1, 0], [2, 1, 0], [4, 1, 0], [5, 0, 0]]
    )
    cells = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [2, 6, 5, -1]])
    ratios = width_ratios(points, cells)
    assert ratios[0] == pytest.approx([4.0, 0.25, 4.0, 0.25])
    assert ratios[1] == pytest.approx([4.0, 0.0, 4.0, 0.25])
    assert np.all(ratios[2] == 0.0)


def test_tables_of_mixed_cells() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1.5, 1, 0], [0, 1, 0], [2, 0, 0]])
    cells = np.array([[0, 1, 2, 3], [1, 4, 2, -1]])
    ends, owner = sides(cells)
    assert ends.tolist() == [[0, 1], [1, 2], [2, 3], [3, 0], [1, 4], [4, 2], [2, 1]]
    assert owner.tolist() == [0, 0, 0, 0, 1, 1, 1]
    assert np.allclose(centres(points, cells), [[0.625, 0.5, 0], [1.5, 1 / 3, 0]])
    assert np.allclose(area_vectors(points, cells)[:, 2], [1.25, 0.5])
    nodes, share = corner_areas(points, cells)
    q = quadrilaterals(points, cells[:1], np.array([1.0, 0, 0]))
    assert nodes.tolist() == [0, 1, 2, 3, 1, 4, 2]
    assert np.allclose(share[:4], q.weight[0] @ q.interpolation, rtol=1e-14)
    assert np.allclose(share[4:], 0.5 / 3)
