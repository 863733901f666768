"""Refinement where the error sits: hanging nodes, corners, meshes of given elements."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.estimate import worst_cells
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.space.section_cells import CellMesh, refined
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.preprocess.section.space.space import SectionSpace
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.package.common.materials import isotropic
from plymotion.solver.package.section.section_schema import SectionFile

STEEL = {"kind": "isotropic", "E": 210e9, "nu": 0.3, "rho": 7850.0}
PLY = {
    "kind": "orthotropic",
    **{"E1": 142e9, "E2": 9.8e9, "E3": 9.8e9, "G12": 6e9, "G13": 6e9, "G23": 4.8e9},
    **{"nu12": 0.42, "nu13": 0.42, "nu23": 0.42, "rho": 1600.0},
}
# A tube of two cells with sharp corners, of elements that are not graded.
TWO_CELLS = """
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 0.1, 0.04};
Rectangle(2) = {0.004, 0.004, 0, 0.036, 0.032};
Rectangle(3) = {0.044, 0.004, 0, 0.052, 0.032};
BooleanDifference(9) = { Surface{1}; Delete; }{ Surface{2, 3}; Delete; };
Physical Surface("section") = {9};
Mesh.MeshSizeMax = 0.004;
Mesh.ElementOrder = 2;
"""


def with_hanging_nodes(kind: str, times: int = 3) -> CellMesh:
    """A curved mesh, refined several times at one place."""
    sizes = {"outer_radius": 1.0, "wall": 0.4, "span_deg": 90.0}
    mesh = section_mesh(expand("tube", sizes), "arc").cells
    if kind == "triangle":
        nodes = np.full((2 * mesh.n_cell, 9), -1)
        for half, corners in enumerate(((0, 1, 2, 4, 5, 8), (0, 2, 3, 8, 6, 7))):
            nodes[half::2, :6] = mesh.nodes[:, corners]
        some = np.repeat(mesh.region, 2)
        mesh = CellMesh(mesh.points, nodes, np.zeros(len(nodes), int), some, mesh.regions)
    for _ in range(times):
        near = np.hypot(*(mesh.middles - [0.75, 0.1]).T)
        mesh = refined(mesh, near < np.sort(near)[2])
    return mesh


@pytest.mark.parametrize("kind", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [2, 3])
def test_polynomials_pass_hanging_nodes(kind: str, degree: int) -> None:
    """Fields of the degree of the map are continuous; the area does not change."""
    mesh = with_hanging_nodes(kind)
    assert len(mesh.hanging) > 4
    space = SectionSpace(mesh, degree)
    coarse = SectionSpace(with_hanging_nodes(kind, 0), degree)
    assert space.area == pytest.approx(coarse.area, rel=1e-12)
    W = space.displacements((space.x2, 2.0 * space.x3, 1.0 - space.x2))
    strain = space.strain_in_section(W)[space.weights > 0.0][..., 0]
    expected = [0.0, 0.0, 0.0, -1.0, 0.0, 1.0]  # w1,2 = 1, w2,3 = 2, w3,2 = -1
    expected[3] += 2.0
    assert strain == pytest.approx(np.broadcast_to(expected, strain.shape), abs=1e-10)


@pytest.mark.parametrize("kind", ["triangle", "quadrilateral"])
def test_functions_are_continuous_across_hanging_nodes(kind: str) -> None:
    """The value at a hanging corner is that of the long edge at its middle."""
    mesh = with_hanging_nodes(kind)
    space = SectionSpace(mesh, 2)
    W = np.random.default_rng(0).standard_normal((space.n_dof, 1))
    (values,) = space.at_corners_and_middles(W)
    at: dict[int, Any] = {}
    for nodes, value in zip(mesh.nodes, values[..., 0], strict=True):
        for node, one in zip(nodes[nodes >= 0], value, strict=False):
            assert one == pytest.approx(at.setdefault(int(node), one), abs=1e-12)


def test_stiffness_is_symmetric_with_four_rigid_motions() -> None:
    space = SectionSpace(with_hanging_nodes("quadrilateral"), 2)
    C = np.broadcast_to(isotropic(1.0, 0.3, 1.0).stiffness_M, (space.n_cell, 1, 6, 6))
    E = space.E(C).toarray()
    assert np.abs(E - E.T).max() < 1e-13 * np.abs(E).max()
    values = np.linalg.eigvalsh(E)
    assert np.count_nonzero(values < 1e-11 * values[-1]) == 4


def test_neighbours_differ_by_one_division() -> None:
    mesh = with_hanging_nodes("quadrilateral", 5)
    ends = {tuple(sorted(edge)) for edge in zip(*mesh.edge_table[1:], strict=True)}
    for a, b, m in mesh.hanging.tolist():
        assert tuple(sorted((a, b))) in ends
        assert tuple(sorted((a, m))) in ends
        assert tuple(sorted((m, b))) in ends


def test_worst_cells() -> None:
    assert worst_cells(np.array([1.0, 8.0, 1.0]), 0.8).tolist() == [False, True, False]
    assert worst_cells(np.array([1.0, 8.0, 1.0]), 0.85).sum() == 2


def two_cells(folder: Path, recombined: bool) -> dict[str, Any]:
    """The tube in a mesh of triangles or of quadrilaterals."""
    script = folder / f"tube-{recombined}.geo"
    extra = "Mesh.RecombineAll = 1;\nMesh.SubdivisionAlgorithm = 1;\n" if recombined else ""
    script.write_text(TWO_CELLS + extra)
    return {
        "mesh": {"file": str(script)},
        "materials": {"m": STEEL},
        "regions": {"section": {"plies": [{"material": "m"}]}},
    }


@pytest.fixture(scope="module")
def fine(tmp_path_factory: pytest.TempPathFactory) -> SectionFile:
    """The tube to 3e-5, of quadrilaterals."""
    return analyse(two_cells(tmp_path_factory.mktemp("fine"), True), accuracy=3e-5)


@pytest.mark.one_end
@pytest.mark.parametrize("recombined", [False, True])
def test_two_cells_with_sharp_corners(recombined: bool, fine: SectionFile, tmp_path: Path) -> None:
    """1e-4 with at most 40,000 unknowns, in a mesh of triangles or of quadrilaterals."""
    found = analyse(two_cells(tmp_path, recombined), accuracy=1e-4)
    assert found.provenance["dofs"] < 40_000
    error = scaled(found.K - fine.K, fine.K).max()
    assert error < 1e-4
    estimate = scaled(np.asarray(found.error_estimate), fine.K).max()
    assert error < 1.5 * estimate
    steps = found.provenance["refinements"]
    assert steps[0]["error"] > 10.0 * steps[-1]["error"]
    assert found.warnings == ()


def round_wall(start_deg: float) -> dict[str, Any]:
    return {
        "convention": "cartesian",
        "mesh": expand("tube", {"outer_radius": 0.1, "wall": 0.01, "start_deg": start_deg}),
        "materials": {"m": PLY},
        "regions": {
            "wall": {
                "plies": [{"material": "m", "angle_deg": 30.0}],
                "direction": {"circle": [0.0, 0.0]},
            }
        },
    }


@pytest.mark.one_end
@pytest.mark.provokes("direction-reverses")
def test_cartesian_directions_of_a_round_wall() -> None:
    """A mesh line at the reversal converges; without one, the doubt is in the estimate."""
    exact = analyse(round_wall(0.0), accuracy=1e-5)
    assert exact.warnings == ()
    found = analyse(round_wall(17.0), accuracy=1e-4)
    assert [w["code"] for w in found.warnings] == ["direction-reverses"]
    error = scaled(found.K - exact.K, exact.K).max()
    assert 1e-3 < error < scaled(np.asarray(found.error_estimate), exact.K).max()
