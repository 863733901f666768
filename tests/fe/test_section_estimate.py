"""The error estimate against true errors, and refinement to an accuracy."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.section_cases import section

from plymotion.preprocess.section.estimate import cell_exponents, error_of_edges, exponent
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_problem import SectionProblem, section_problem
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.space.section_cells import CellMesh, refined
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.package.common.materials import Orthotropic, isotropic, ply_rotation, rotated

pytestmark = pytest.mark.one_end

SMALL = 0.05  # errors below this share of the worst one are irrelevant


CURVED = ["07", "14"]


@cache
def converged(name: str) -> Any:
    """K of a finer mesh and a higher degree; curved walls need the mesh, corners the degree."""
    density, degree = (3.0, 3) if name in CURVED else (1.5, 4)
    return analyse(section(name, density, degree=degree), estimate=False).K


def compared(name: str, density: float, degree: int) -> tuple[Any, Any]:
    """Scaled errors and estimates of all entries."""
    found = analyse(section(name, density, degree=degree))
    exact = converged(name)
    return scaled(found.K - exact, exact), scaled(np.asarray(found.error_estimate), exact)


@pytest.mark.parametrize("name", ["02", "08", "11", "12", "15", "21", "22"])
@pytest.mark.parametrize(("density", "degree"), [(0.5, 2), (1.0, 2), (0.5, 3)])
def test_estimate_bounds_the_error(name: str, density: float, degree: int) -> None:
    """The largest estimate is slightly above the largest error; relevant entries are close."""
    error, estimate = compared(name, density, degree)
    assert 1.0 < estimate.max() / error.max() < 2.6
    counts = error > SMALL * error.max()
    ratio = estimate[counts] / error[counts]
    assert ratio.min() > 0.65
    assert ratio.max() < 2.6


@pytest.mark.parametrize("name", CURVED)
@pytest.mark.parametrize(("degree", "least", "most"), [(2, 1.0, 2.6), (3, 0.9, 1.3)])
def test_estimate_bounds_the_largest_error_of_curved_walls(
    name: str, degree: int, least: float, most: float
) -> None:
    """With degree 3 nearly all of the error is the distance of the edges from circles."""
    error, estimate = compared(name, 1.0, degree)
    assert least < estimate.max() / error.max() < most


QUARTERS = {"stiff": 100.0, "soft": 1.0, "ply": 10.0}


def quarters(folder: Path, layout: str) -> dict[str, Any]:
    """A square of nine blocks of 3 x 3 cells; layout: one letter a block, or - for a void."""
    names = {"s": "stiff", "o": "soft", "p": "ply"}
    used = sorted({names[c] for c in layout if c != "-"})
    line = np.arange(10)
    points = 0.1 * np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    cells, region = [], []
    for i, j in np.ndindex(9, 9):
        block = layout[3 * (i // 3) + j // 3]
        if block != "-":
            cells.append([10 * i + j, 10 * i + j + 10, 10 * i + j + 11, 10 * i + j + 1])
            region.append(used.index(names[block]))
    path = folder / f"{layout}.npz"
    np.savez(path, points=points, cells=cells, cell_type="quad", region=region, region_names=used)
    ply = {"E1": 140e9, "E2": 9e9, "E3": 9e9, "G12": 5e9, "G13": 5e9, "G23": 3e9, "rho": 1600.0}
    ply |= {"kind": "orthotropic", "nu12": 0.3, "nu13": 0.3, "nu23": 0.4}
    materials = {
        name: {"kind": "isotropic", "E": 1e9 * QUARTERS[name], "nu": 0.3, "rho": 1000.0}
        for name in used
    }
    materials |= {"ply": ply} if "ply" in used else {}
    angle = {"ply": 45.0}
    return {
        "mesh": {"arrays": str(path), "degree": 2},
        "materials": materials,
        "convention": "cartesian",
        "regions": {
            name: {
                "plies": [{"material": name, "angle_deg": angle.get(name, 0.0)}],
                "direction": {"vector": [1.0, 0.0]},
            }
            for name in used
        },
    }


def refined_at_corners(spec: dict[str, Any], levels: int) -> Any:
    """K of degree 3 on cells that are halved towards the corners of all blocks."""
    problem = section_problem(spec, "quarters", 2)
    cells = problem.mesh.cells
    places = 0.3 * np.stack(np.meshgrid(*2 * [np.arange(4)]), axis=-1).reshape(-1, 2)
    for _ in range(levels):
        corners = cells.points[cells.nodes[:, :4]]
        apart = np.abs(corners[:, :, None] - places).max(axis=-1).min(axis=(1, 2))
        cells = refined(cells, apart < 1e-9)
    finer = SectionProblem(replace(problem.mesh, cells=cells), 3)
    lay = layup(spec, finer.mesh, finer.space, "quarters")
    return finer.solve(lay.stiffness, measured=False).K


@pytest.mark.parametrize(
    "layout", ["sososoooo", "so-ososo-", "pso-opsop", "ssos-osss", "pppppooop", "ssssss-ss"]
)
def test_estimate_where_stiff_and_soft_parts_meet(tmp_path: Path, layout: str) -> None:
    """Crosses of stiff and soft quarters, corners of voids, ends of plies."""
    spec = quarters(tmp_path, layout)
    exact = refined_at_corners(spec, 20)
    found = analyse(spec)
    error = scaled(found.K - exact, exact)
    estimate = scaled(np.asarray(found.error_estimate), exact)
    assert 0.85 < estimate.max() / error.max() < 3.0
    counts = error > 0.3 * error.max()
    assert (estimate[counts] / error[counts]).min() > 0.75


def test_exponents_of_corners_by_closed_forms() -> None:
    """Williams's corner and crack; stiff and soft quarters crosswise in torsion (antiplane)."""
    one = isotropic(1.0, 0.3, 1.0).stiffness_M
    turn = np.radians([0.0, 90.0, 180.0, 270.0, 360.0])
    assert exponent(turn[[0, 3]], [one], closed=False) == pytest.approx(0.544484, rel=1e-4)
    assert exponent(turn[[0, 4]], [one], closed=False) == pytest.approx(0.5, rel=1e-3)
    assert exponent(turn[[0, 2]], [one], closed=False) == pytest.approx(1.0, rel=1e-3)
    for ratio in (10.0, 1e3, 1e4):
        found = exponent(turn, [ratio * one, one, ratio * one, one], closed=True)
        assert found == pytest.approx(4.0 / np.pi * np.arctan(ratio**-0.5), rel=1e-4)


def test_exponents_do_not_change_when_a_section_is_turned() -> None:
    """Corners of an L of anisotropic plies, which the directions of its edges do not suit."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners = np.concatenate([square + shift for shift in ([0, 0], [1, 0], [0, 1])])
    points, rows = np.unique(corners, axis=0, return_inverse=True)
    nodes = np.full((3, 9), -1)
    nodes[:, :4] = rows.reshape(3, 4)
    constants = Orthotropic(142e9, 9.8e9, 9.8e9, 6.0e9, 6.0e9, 4.8e9, 0.42, 0.42, 0.42, 1600.0)
    plies = np.stack([rotated(constants.stiffness_M, ply_rotation(t)) for t in (60.0, 20.0, -45.0)])
    found = []
    for angle in (0.0, 0.7):
        c, s = np.cos(angle), np.sin(angle)
        mesh = CellMesh(
            points @ np.array([[c, s], [-s, c]]),
            nodes,
            np.ones(3, dtype=np.int64),
            np.zeros(3, dtype=np.int64),
            ("L",),
        )
        turned = rotated(plies, np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]))
        found.append(cell_exponents(mesh, turned[:, None], np.ones(3), 1.0))
    assert found[0].max() < 0.99
    assert found[1] == pytest.approx(found[0], rel=1e-9)


def test_estimate_of_round_edges_by_closed_forms() -> None:
    """Disc, ellipse, and a tube whose inner half is 100 times as stiff: plies have edges, too."""
    nu, G = 0.3, 0.5 / 1.3
    disc = {"section": {"plies": [{"material": "soft"}], "direction": {"vector": [1.0, 0.0]}}}
    plies = [{"material": name, "thickness": 0.25} for name in ("soft", "stiff")]
    wall = {"wall": {"plies": plies, "direction": {"circle": [0.0, 0.0]}}}
    sizes = {"outer_radius": 1.0, "wall": 0.5}
    radii = np.array([1.0, 0.75, 0.5])
    E = np.array([1.0, 100.0])
    area, polar = -np.pi * np.diff(radii**2), -0.5 * np.pi * np.diff(radii**4)
    for mesh, regions, exact in (
        (expand("ellipse", {"radius_2": 1.0}), disc, [np.pi, 0.5 * np.pi * G, 0.25 * np.pi]),
        (
            expand("ellipse", {"radius_2": 0.4, "radius_3": 1.0}),
            disc,
            [0.4 * np.pi, 0.4**3 / 1.16 * np.pi * G, 0.1 * np.pi],
        ),
        (
            expand("tube", sizes, {"wall": [0.25, 0.25]}),
            wall,
            [E @ area, G * E @ polar, E @ polar / 2],
        ),
    ):
        found = analyse(
            {
                "mesh": {**mesh, "degree": 3},
                "materials": {
                    name: {"kind": "isotropic", "E": e, "nu": nu, "rho": 1.0}
                    for name, e in (("soft", 1.0), ("stiff", 100.0))
                    if name == "soft" or regions is wall
                },
                "regions": regions,
            }
        )
        error = np.abs(np.diag(found.K)[[0, 3, 4]] / exact - 1.0).max()
        estimate = np.diag(scaled(np.asarray(found.error_estimate), found.K)).max()
        assert 1e-6 < error < estimate < 1.3 * error


LENS = [(-0.5, 1.0, -60.0, 60.0), (0.5, 1.0, 120.0, 240.0)]
OVAL = [
    *[(0.95, 0.05, -60.0, 60.0), (-1.9j * np.sin(np.pi / 3.0), 1.95, 60.0, 120.0)],
    *[(-0.95, 0.05, 120.0, 240.0), (1.9j * np.sin(np.pi / 3.0), 1.95, 240.0, 300.0)],
]


@pytest.mark.parametrize(
    "arcs", [LENS, OVAL], ids=["at a corner", "at another radius, with the same tangent"]
)
def test_estimate_of_arcs_that_end(arcs: list[tuple[complex, float, float, float]]) -> None:
    """What lies beyond says nothing about an arc. Arcs: centre, radius, first and last angle."""
    n, m = 4, 4 * len(arcs)  # triangles about the origin, with one curved edge each
    corners, middles, edges = [], [], []
    for centre, radius, first, last in arcs:
        edge = np.radians(np.linspace(first, last, 2000 * n + 1))
        arc = centre + radius * np.exp(1j * edge)
        corners.append(arc[:-1:2000])
        middles.append(arc[1000::2000])
        edges += [arc[2000 * k : 2000 * k + 2001] for k in range(n)]
    corner, middle = np.concatenate(corners), np.concatenate(middles)
    places = np.concatenate([[0.0], corner, middle, 0.5 * corner])
    start = np.arange(m)
    end = np.roll(start, -1)
    nodes = np.full((m, 9), -1)
    nodes[:, 0] = 0
    nodes[:, 1:6] = 1 + np.column_stack([start, end, 2 * m + start, m + start, 2 * m + end])
    none = np.zeros(m, dtype=np.int64)
    mesh = CellMesh(np.column_stack([places.real, places.imag]), nodes, none, none, ("all",))
    s = np.linspace(-1.0, 1.0, 2001)
    at = np.array([0.5 * s * (s - 1.0), 1.0 - s**2, 0.5 * s * (s + 1.0)])
    parabolas = np.column_stack([corner, middle, np.roll(corner, -1)]) @ at
    whole = sum(_moments(edge) for edge in edges)
    lost = whole - sum(_moments(parabola) for parabola in parabolas)
    expected = np.abs(lost / whole).max()
    # The section counts as the polygon of its corners, which is smaller.
    assert expected < error_of_edges(mesh, np.ones(m)) < 1.2 * expected


def _moments(line: np.ndarray) -> np.ndarray:
    """Area and second moments between the origin and a line of many points, as complex numbers."""
    middle, step = 0.5 * (line[1:] + line[:-1]), np.diff(line)
    twice = (middle.conj() * step).imag
    squares = np.column_stack([middle.real**2, middle.imag**2])
    return np.array([0.5 * twice.sum(), *(0.25 * twice @ squares)])


def test_straight_edges_have_no_error_of_arcs() -> None:
    """Also with one row of cells, whose middles lie on one line."""
    mesh = section_mesh(expand("rectangle", {"width": 1.0, "height": 1e-5, "elements_3": 1}), "x")
    assert error_of_edges(mesh.cells, np.ones(mesh.cells.n_cell)) < 1e-15


def test_refinement_meets_the_accuracy_and_says_what_it_cost() -> None:
    loose = analyse(section("21", 0.5))
    found = analyse(section("21", 0.5), accuracy=1e-4)
    exact = converged("21")
    assert scaled(np.asarray(found.error_estimate), exact).max() < 1e-4
    assert scaled(found.K - exact, exact).max() < 1e-4
    steps = found.provenance["refinements"]
    assert [step["refine"] for step in steps] == list(range(len(steps)))
    assert steps[0]["dofs"] == loose.provenance["dofs"] < steps[-1]["dofs"]
    assert [step["error"] > 1e-4 for step in steps] == [True] * (len(steps) - 1) + [False]
    assert found.warnings == ()


@pytest.mark.provokes("accuracy-not-met")
def test_an_accuracy_out_of_reach_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    from plymotion.preprocess.section import section_analysis

    monkeypatch.setattr(section_analysis, "MOST_DOFS", 5000)
    found = analyse(section("02"), accuracy=1e-9)
    assert [warning["code"] for warning in found.warnings] == ["accuracy-not-met"]
    assert found.provenance["refinements"][-1]["error"] > 1e-9
