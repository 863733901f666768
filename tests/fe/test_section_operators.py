"""E, H, L of the section against the same integrals by NumPy alone (section_verification.py)."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ufl

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx import PlainMesh, gmsh, plain_from_model
from plymotion.preprocess.fenicsx.kernels import compiled_text
from plymotion.preprocess.fenicsx.libraries import dolfinx
from plymotion.preprocess.section.helical import TwistedStrains
from plymotion.preprocess.section.section_problem import SectionProblem
from plymotion.preprocess.section.section_verification import matrices
from plymotion.preprocess.section.space.numbering import Pattern
from plymotion.preprocess.section.space.section_cells import cells_of_plain
from plymotion.preprocess.section.space.section_mesh import SectionMesh
from plymotion.preprocess.section.space.space import SectionSpace
from plymotion.solver.package.common.materials import Orthotropic, isotropic, ply_rotation, rotated

MESHES = Path(__file__).resolve().parents[2] / "meshes"
PLY = Orthotropic(142e9, 9.8e9, 9.8e9, 6.0e9, 6.0e9, 4.8e9, 0.42, 0.42, 0.42, 1600.0)
C_30 = rotated(PLY.stiffness_M, ply_rotation(30.0))


def triangles(order: int) -> PlainMesh:
    """A disc cut by a plane, of curved (order 2) or straight triangles."""
    with fenicsx.gmsh_session():
        gmsh.clear()
        disc = gmsh.model.occ.addDisk(0.0, 0.0, 0.0, 1.5, 1.0)
        gmsh.model.occ.synchronize()
        group = gmsh.model.addPhysicalGroup(2, [disc])
        gmsh.model.setPhysicalName(2, group, "section")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        return plain_from_model("gmsh model", 2)


def ellipse() -> PlainMesh:
    values = {"radius_2": 2.0, "radius_3": 1.0, "elements_arc": 8, "elements_radial": 2}
    return fenicsx.run_script(MESHES / "ellipse.geo", values)


CASES = {
    "quadrilaterals": (ellipse, 2),
    "quadrilaterals, degree 3": (ellipse, 3),
    "triangles": (lambda: triangles(2), 2),
    "triangles, degree 3": (lambda: triangles(2), 3),
    "straight triangles, degree 1": (lambda: triangles(1), 1),
    "straight triangles, degree 3": (lambda: triangles(1), 3),
}


def agree(space: SectionSpace, strains_of: Any, C: Any, E: Any, H: Any, L: Any) -> None:
    """E is assembled; H and L never are: their products with random columns."""
    assert abs(strains_of.E(C[:, None]) - E).max() < 1e-12 * abs(E).max()
    X = np.random.default_rng(3).standard_normal((space.n_dof, 3))
    stress_h = C[:, None] @ strains_of.strain_in_section(X)
    stress_l = C[:, None] @ strains_of.strain_along_beam(X)
    for product, theirs in (
        (strains_of.load_in_section(stress_l), H @ X),
        (strains_of.load_along_beam(stress_h), H.T @ X),
        (strains_of.load_along_beam(stress_l), L @ X),
        (strains_of.load_in_section(stress_h), E @ X),
    ):
        assert np.abs(product - theirs).max() < 1e-12 * np.abs(theirs).max()


@pytest.mark.parametrize("name", CASES)
def test_matrices_are_those_of_the_judge(name: str) -> None:
    """Paper: Eq. (37), Eq. (38)."""
    make, degree = CASES[name]
    space = SectionSpace(cells_of_plain(make()), degree)
    # another material in every cell, so that symmetry does not hide errors
    factor = 1.0 + np.random.default_rng(1).random(space.n_cell)
    C = factor[:, None, None] * C_30
    agree(space, space, C, *matrices(space, C[:, None]))


def test_twisted_strains_are_those_of_the_judge() -> None:
    space = SectionSpace(cells_of_plain(triangles(2)))
    C = (1.0 + np.random.default_rng(1).random(space.n_cell))[:, None, None] * C_30
    k = np.array([0.5, 0.3, -0.4])
    agree(space, TwistedStrains(space, k), C, *matrices(space, C[:, None], k))


def torsion_of_a_square() -> float:
    """GJ of a square of side 1 and shear modulus 1, on a new space: exactly 0.140577."""
    halves = {"columns": [0.5, 1.0], "rows": [0.5, 1.0]}
    sizes = {"width": 1.0, "height": 1.0, **halves}
    cells = cells_of_plain(fenicsx.run_script(MESHES / "rectangle.geo", sizes))
    problem = SectionProblem(SectionMesh(cells, {}), 4)
    C = isotropic(2.0, 0.0, 1.0).stiffness_M
    return float(problem.solve(np.broadcast_to(C, (cells.n_cell, 1, 6, 6))).K[3, 3])


def test_stiffness_comes_from_the_text_of_the_strains(monkeypatch: pytest.MonkeyPatch) -> None:
    assert torsion_of_a_square() == pytest.approx(0.140577, rel=2e-3)

    def half(w: Any, _d: Any = None) -> Any:
        return ufl.as_vector([w[0], 0, 0, 0, w[2], w[1] / 2])

    monkeypatch.setattr("plymotion.preprocess.section.space.space.strain_along_beam", half)
    assert torsion_of_a_square() < 0.95 * 0.140577


def test_stiffness_comes_from_what_dolfinx_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = dolfinx.jit.ffcx_jit

    def damaged(comm: Any, text: Any, **options: Any) -> Any:
        """The slope u,3 half as large, everything else as it is."""
        expression, points = text
        if ufl.algorithms.extract_arguments(expression):
            expression = ufl.as_vector([expression[0], expression[1], expression[2] / 2])
        return compiled(comm, (expression, points), **options)

    monkeypatch.setattr(dolfinx.jit, "ffcx_jit", damaged)
    compiled_text.cache_clear()
    try:
        assert torsion_of_a_square() < 0.95 * 0.140577
    finally:
        compiled_text.cache_clear()


def test_point_by_point_and_cell_by_cell_agree() -> None:
    space = SectionSpace(cells_of_plain(ellipse()))
    of_cells = space.E(np.broadcast_to(C_30, (space.n_cell, 1, 6, 6)))
    of_points = space.E(np.broadcast_to(C_30, (*space.weights.shape, 6, 6)))
    assert abs(of_cells - of_points).max() < 1e-13 * abs(of_cells).max()


def test_work_of_stress_on_strain_is_the_energy_of_the_matrix() -> None:
    space = SectionSpace(cells_of_plain(triangles(2)))
    E = space.E(np.broadcast_to(C_30, (space.n_cell, 1, 6, 6)))
    W = np.random.default_rng(2).standard_normal((space.n_dof, 2))
    strain = space.strain_in_section(W)
    assert space.work(C_30 @ strain, strain) == pytest.approx(W.T @ (E @ W), rel=1e-12)


def test_points_and_weights_hold_the_area() -> None:
    space = SectionSpace(cells_of_plain(ellipse()))
    assert space.area == pytest.approx(2.0 * np.pi, rel=2e-5)
    assert np.sum(space.weights * space.points[..., 0] ** 2) == pytest.approx(
        0.25 * np.pi * 2.0**3, rel=1e-4
    )


def test_curved_cells_are_told_from_straight_ones() -> None:
    for make in (ellipse, lambda: triangles(2)):
        assert cells_of_plain(make()).is_curved
    straight = fenicsx.run_script(
        MESHES / "rectangle.geo",
        {"width": 1.0, "height": 0.5, "columns": [0.2, 0.8, 1.0], "rows": [0.3, 1.0]},
    )
    assert not cells_of_plain(straight).is_curved


def test_pattern_without_pins_is_the_submatrix() -> None:
    space = SectionSpace(cells_of_plain(ellipse()))
    E = space.E(np.broadcast_to(C_30, (space.n_cell, 1, 6, 6)))
    pins = np.array([0, 1, 2, 17])
    kept = space.pattern.without(pins)
    free = np.setdiff1d(np.arange(space.n_dof), pins)
    difference = kept.matrix(E.data) - E[free][:, free]
    assert abs(difference).max() == 0.0


def test_pattern_adds_what_cells_share() -> None:
    """Two cells of two nodes that share node 1."""
    pattern = Pattern(np.array([[0, 1], [1, 2]], dtype=np.int32), 3)
    blocks = np.tile(np.eye(3).ravel(), (2, 4, 1))
    expected = np.kron([[1, 1, 0], [1, 2, 1], [0, 1, 1]], np.eye(3))
    assert np.array_equal(pattern.matrix(pattern.data(blocks)).toarray(), expected)
