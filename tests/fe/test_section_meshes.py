"""Meshes of sections: the library's scripts, refinement, walls and plies."""

import importlib
import shutil
import sys
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.section_mesh_samples import CFRP, ISOTROPIC, SIZES, library, moments, nodes_of

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.space import section_mesh as reading
from plymotion.preprocess.section.space.section_cells import KINDS as CELL_KINDS
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.solver.inputs.section.shapes.library import SHAPES, expand, walls
from plymotion.solver.math.arrays import Array

AREAS = {
    "rectangle": 0.06 * 0.015,
    "strip": 0.06 * 0.002,
    "split-rectangle": 0.1 * 0.08,
    "ellipse": pi * 0.02 * 0.01,
    "tube": pi * (0.1**2 - 0.09**2),
    "box": 0.03 * 0.02 - (0.03 - 0.003) * (0.02 - 0.0025),
    "two-cell": 0.05 * 0.02 - 0.048 * 0.018 + 0.001 * 0.018,
    "i": 0.1 * 0.01 + 0.08 * 0.01 + 0.18 * 0.006,
    "polyline": 0.002 * (0.051 + 0.098 + 0.051),
    "channel": 0.0015 * (0.025 + 0.0105 + 0.0235),
}


@pytest.mark.parametrize("name", SHAPES)
def test_library(name: str, record: Callable[[str, Any], None]) -> None:
    """Nine-node cells, the regions of the table, the area of the closed form, no warning."""
    mesh = library(name)
    assert set(mesh.cells.regions) == {wall.region for wall in walls(name, SIZES[name])}
    assert mesh.cells.kind.min() == CELL_KINDS.index("quadrilateral")
    assert mesh.cells.degree == 2
    assert mesh.warnings == ()
    if name in AREAS:
        assert moments(mesh)[0] == pytest.approx(AREAS[name], rel=1e-5)
    record(f"mesh/{name}/moments", moments(mesh) / moments(mesh)[0])


@pytest.mark.one_end
@pytest.mark.parametrize("name", SHAPES)
def test_scripts_stand_alone(name: str, repository_root: Path, tmp_path: Path) -> None:
    """As in the gmsh window: with their own defaults, from any folder."""
    if name == "airfoil":
        coordinates = np.loadtxt(repository_root / "meshes/airfoils/naca0012.dat", skiprows=1)
        spec = {"script": "airfoil", "parameters": {}, "coordinates": coordinates.tolist()}
        assert len(section_mesh(spec, "airfoil").cells.regions) == 6
        return
    for script in (repository_root / "meshes").glob("*.geo"):
        shutil.copy(script, tmp_path)
    mesh = section_mesh({"file": str(tmp_path / f"{SHAPES[name].script}.geo")}, name)
    expected = walls(name, SHAPES[name].example)
    assert set(mesh.cells.regions) == {wall.region for wall in expected}
    assert mesh.warnings == ()


@pytest.fixture
def repository_root() -> Path:
    return Path(__file__).resolve().parent.parent.parent


def test_arcs_lie_on_their_circle() -> None:
    nodes = nodes_of(library("tube"), "wall").reshape(-1, 2)
    radius = np.hypot(*nodes.T)
    # two rows by default: their faces are curves of the script
    for face in (0.09, 0.095, 0.1):
        near = np.abs(radius - face) < 1e-5
        assert np.count_nonzero(near) > 30
        assert np.abs(radius[near] - face).max() < 1e-13


@pytest.mark.one_end
def test_thin_curved_rows_do_not_fold(tmp_path: Path) -> None:
    """A tube of 16 plies, radius 200 times the wall; as a script of the library and of a user."""
    spec = expand("tube", {"outer_radius": 0.1, "wall": 0.0005}, {"wall": [1.0] * 16})
    mesh = section_mesh(spec, "tube")
    assert mesh.warnings == ()
    assert moments(mesh)[0] == pytest.approx(pi * (0.1**2 - 0.0995**2), rel=1e-5)
    ring = library("tube")
    for script in (Path(__file__).resolve().parents[2] / "meshes").glob("*.geo"):
        shutil.copy(script, tmp_path)
    user = {"file": str(tmp_path / "tube.geo"), "parameters": spec["parameters"]}
    assert section_mesh(user, "tube").cells.n_cell == 36 * 16
    assert ring.cells.regions == section_mesh(user, "tube").cells.regions


@pytest.mark.one_end
@pytest.mark.parametrize("name", [n for n in SHAPES if n not in ("airfoil", "two-cell", "i")])
def test_default_mesh_is_converged(name: str) -> None:
    """Halving every element changes no entry of K by more than 3e-4 of sqrt(Kii Kjj)."""
    coarse, fine = (stiffness(expand(name, SIZES[name]), name, refine) for refine in (0, 1))
    size = np.sqrt(np.diag(fine))
    assert (np.abs(coarse - fine) / np.outer(size, size)).max() < 3e-4


def stiffness(mesh: dict[str, Any], name: str, refine: int = 0) -> Array:
    """K of an isotropic section; one more degree stands for halved elements."""
    regions = {
        wall.region: {"plies": [{"material": "m", "angle_deg": 0.0}]}
        for wall in walls(name, SIZES[name])
    }
    spec = {
        "name": name,
        "convention": "contour",
        "mesh": {**mesh, "degree": 2 + refine},
        "materials": {"m": ISOTROPIC},
        "regions": regions,
    }
    return np.asarray(analyse(spec, estimate=False).K)


THIN_LAMINATES: dict[str, dict[str, Any]] = {
    "tube": {"outer_radius": 0.05, "wall": 0.0005, "span_deg": 180.0},
    "channel": {"height": 0.1, "top_width": 0.05, "wall": 0.0005},
    "i": {"height": 0.1, "top_width": 0.05, "wall": 0.0005},
    "box": {"width": 0.05, "height": 0.02, "wall": 0.0005},
}


@pytest.mark.one_end
@pytest.mark.parametrize("name", THIN_LAMINATES)
def test_thin_unsymmetric_walls_bend(name: str) -> None:
    """Elements of 10 degrees would make K33 of this half tube 20 % too small."""
    angles = [45.0, -45.0, 0.0, 90.0]
    plies = [{"material": "c", "angle_deg": angle} for angle in angles]
    regions = {
        wall.region: {"plies": plies, "direction": dict(wall.direction)}
        for wall in walls(name, THIN_LAMINATES[name])
    }
    mesh = expand(name, THIN_LAMINATES[name], {region: [1.0] * 4 for region in regions})
    spec = {"name": name, "materials": {"c": CFRP}, "regions": regions}
    coarse, fine = (
        analyse({**spec, "mesh": {**mesh, "degree": degree}}, estimate=False).K for degree in (2, 3)
    )
    size = np.sqrt(np.diag(fine))
    assert (np.abs(coarse - fine) / np.outer(size, size)).max() < 5e-4


@pytest.mark.one_end
@pytest.mark.parametrize("name", ["box", "two-cell", "i", "channel", "rectangle", "tube"])
def test_every_ply_ends_on_element_edges(name: str) -> None:
    """Unequal plies, of another number in every wall: the engine finds no cell with two plies."""
    shape_walls = walls(name, SIZES[name])
    sizes = {key: value for key, value in SIZES[name].items() if not key.startswith("wall_")}
    layers = {w.region: [1.0, 2.0, 1.0, 3.0][: 2 + i % 3] for i, w in enumerate(shape_walls)}
    regions = {}
    for wall in shape_walls:
        thickness = sizes.get(wall.thickness, sizes.get("wall"))
        plies = [
            {"material": "c", "angle_deg": 30.0 * i, "thickness": thickness * share / total}
            for i, share in enumerate(layers[wall.region])
            for total in [sum(layers[wall.region])]
        ]
        regions[wall.region] = {"plies": plies, "direction": dict(wall.direction)}
    spec = {
        "name": name,
        "convention": "contour",
        "mesh": expand(name, sizes, layers),
        "materials": {"c": CFRP},
        "regions": regions,
    }
    assert analyse(spec, estimate=False).warnings == ()


@pytest.mark.one_end
def test_the_last_digit_of_coordinates_can_be_changed(
    repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """tools/last_digit.py reaches what reads meshes."""
    usual = library("rectangle").cells.points
    for place, name in (
        (fenicsx, "surface_mesh"),
        (reading, "_arrays"),
        (reading, "_mixed_arrays"),
    ):
        monkeypatch.setattr(place, name, getattr(place, name))
    monkeypatch.syspath_prepend(repository / "tools")
    monkeypatch.delitem(sys.modules, "last_digit", raising=False)
    importlib.import_module("last_digit")
    reading._made.cache_clear()
    apart = np.abs(library("rectangle").cells.points - usual)
    reading._made.cache_clear()
    assert 0.0 < apart.max() <= 2.0 * np.spacing(np.abs(usual).max())
