"""E, H, L of the section against the same integrals written in UFL and assembled by DOLFINx."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dolfinx_forms import assembled, cell_function, mesh_from_geo, mesh_from_model

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx import gmsh, ufl
from plymotion.preprocess.materials import Orthotropic, ply_rotation, rotated
from plymotion.preprocess.section.operators import SectionOperators
from plymotion.preprocess.section.pattern import Pattern
from plymotion.preprocess.section.space import SectionSpace, is_curved

MESHES = Path(__file__).resolve().parents[2] / "meshes"
PLY = Orthotropic(142e9, 9.8e9, 9.8e9, 6.0e9, 6.0e9, 4.8e9, 0.42, 0.42, 0.42, 1600.0)
C_30 = rotated(PLY.stiffness_M, ply_rotation(30.0))


def triangles(order: int) -> fenicsx.LabelledMesh:
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
        return mesh_from_model()


def ellipse() -> fenicsx.LabelledMesh:
    values = {"radius_2": 2.0, "radius_3": 1.0, "elements_arc": 8, "elements_radial": 2}
    return mesh_from_geo(MESHES / "ellipse.geo", values)


CASES = {
    "quadrilaterals": (ellipse, 2),
    "quadrilaterals, degree 3": (ellipse, 3),
    "triangles": (lambda: triangles(2), 2),
    "triangles, degree 3": (lambda: triangles(2), 3),
    "straight triangles, degree 1": (lambda: triangles(1), 1),
    "straight triangles, degree 3": (lambda: triangles(1), 3),
}


def assembled_by_dolfinx(space: SectionSpace, C: Any) -> list[Any]:
    """E, H, L with an independent implementation of the strain operators."""
    mesh = space.labelled.mesh
    V = fenicsx.vector_space(mesh, space.degree, 3)
    stiffness = cell_function(mesh, C)

    def in_section(w: Any) -> Any:
        dw = ufl.grad(w)
        return ufl.as_vector([0.0, dw[1, 0], dw[2, 1], dw[1, 1] + dw[2, 0], dw[0, 1], dw[0, 0]])

    def along_beam(w: Any) -> Any:
        return ufl.as_vector([w[0], 0.0, 0.0, 0.0, w[2], w[1]])

    dx = ufl.dx(domain=mesh, metadata={"quadrature_degree": space.quadrature_degree})
    v, u = ufl.TestFunction(V), ufl.TrialFunction(V)
    pairs = [(in_section, in_section), (in_section, along_beam), (along_beam, along_beam)]
    return assembled([ufl.inner(left(v), stiffness * right(u)) * dx for left, right in pairs])


@pytest.mark.parametrize("name", CASES)
def test_matrices_are_those_of_dolfinx(name: str) -> None:
    make, degree = CASES[name]
    space = SectionSpace(make(), degree)
    # another material in every cell, so that symmetry does not hide errors
    factor = 1.0 + np.random.default_rng(1).random(space.n_cell)
    C = factor[:, None, None] * C_30
    E, H, L = assembled_by_dolfinx(space, C)
    ours = SectionOperators(space).E(C[:, None])
    assert abs(ours - E).max() < 1e-12 * abs(E).max()
    # H and L are never assembled: their products with random columns
    X = np.random.default_rng(3).standard_normal((space.n_dof, 3))
    stress_h = C[:, None] @ space.strain_in_section(X)
    stress_l = C[:, None] @ space.strain_along_beam(X)
    for product, theirs in (
        (space.load_in_section(stress_l), H @ X),
        (space.load_along_beam(stress_h), H.T @ X),
        (space.load_along_beam(stress_l), L @ X),
        (space.load_in_section(stress_h), E @ X),
    ):
        assert np.abs(product - theirs).max() < 1e-12 * np.abs(theirs).max()


def test_point_by_point_and_cell_by_cell_agree() -> None:
    space = SectionSpace(ellipse())
    operators = SectionOperators(space)
    of_cells = operators.E(np.broadcast_to(C_30, (space.n_cell, 1, 6, 6)))
    of_points = operators.E(np.broadcast_to(C_30, (*space.weights.shape, 6, 6)))
    assert abs(of_cells - of_points).max() < 1e-13 * abs(of_cells).max()


def test_work_of_stress_on_strain_is_the_energy_of_the_matrix() -> None:
    space = SectionSpace(triangles(2))
    E = SectionOperators(space).E(np.broadcast_to(C_30, (space.n_cell, 1, 6, 6)))
    W = np.random.default_rng(2).standard_normal((space.n_dof, 2))
    strain = space.strain_in_section(W)
    assert space.work(C_30 @ strain, strain) == pytest.approx(W.T @ (E @ W), rel=1e-12)


def test_points_and_weights_hold_the_area() -> None:
    space = SectionSpace(ellipse())
    assert space.area == pytest.approx(2.0 * np.pi, rel=2e-5)
    assert np.sum(space.weights * space.points[..., 0] ** 2) == pytest.approx(
        0.25 * np.pi * 2.0**3, rel=1e-4
    )


def test_curved_cells_are_told_from_straight_ones() -> None:
    for make, curved in ((ellipse, True), (lambda: triangles(2), True)):
        labelled = make()
        nodes, cells, _ = fenicsx.geometry(labelled.mesh)
        assert is_curved(nodes[cells][..., :2], fenicsx.cell_name(labelled.mesh)) is curved
    straight = mesh_from_geo(
        MESHES / "rectangle.geo",
        {"width": 1.0, "height": 0.5, "columns": [0.2, 0.8, 1.0], "rows": [0.3, 1.0]},
    )
    nodes, cells, _ = fenicsx.geometry(straight.mesh)
    assert not is_curved(nodes[cells][..., :2], "quadrilateral")


def test_pattern_without_pins_is_the_submatrix() -> None:
    space = SectionSpace(ellipse())
    E = SectionOperators(space).E(np.broadcast_to(C_30, (space.n_cell, 1, 6, 6)))
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
