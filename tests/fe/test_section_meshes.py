"""Meshes of sections: the library's scripts, the user's files, refinement."""

import shutil
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx import gmsh
from plymotion.preprocess.section import analyse
from plymotion.preprocess.section.cells import KINDS as CELL_KINDS
from plymotion.preprocess.section.cells import full_basis
from plymotion.preprocess.section.curves import nearest_on_curve
from plymotion.preprocess.section.mesh import SectionError, SectionMesh, section_mesh
from plymotion.solver.inputs.section.shapes.library import SHAPES, expand, walls
from plymotion.solver.math.arrays import Array

ISOTROPIC = {"kind": "isotropic", "E": 1.0, "nu": 0.3, "rho": 1.0}
CFRP = {
    "kind": "orthotropic",
    **{"E1": 1.42e11, "E2": 9.8e9, "E3": 9.8e9, "G12": 6e9, "G13": 6e9, "G23": 4.8e9},
    **{"nu12": 0.42, "nu13": 0.42, "nu23": 0.42, "rho": 1600.0},
}
SIZES: dict[str, dict[str, Any]] = {
    "rectangle": {"width": 0.06, "height": 0.015},
    "strip": {"width": 0.06, "height": 0.002},
    "split-rectangle": {"width": 0.1, "height": 0.08, "interface": 0.02},
    "ellipse": {"radius_2": 0.02, "radius_3": 0.01},
    "tube": {"outer_radius": 0.1, "wall": 0.01},
    "box": {"width": 0.03, "height": 0.02, "wall": 0.001, "wall_left": 0.002, "wall_top": 0.0015},
    "two-cell": {"width": 0.05, "height": 0.02, "web_position": 0.01, "wall": 0.001},
    "i": {"height": 0.2, "top_width": 0.1, "bottom_width": 0.08, "wall": 0.01, "wall_web": 0.006},
    "channel": {"height": 0.025, "top_width": 0.012, "bottom_width": 0.025, "wall": 0.0015},
    "airfoil": {"contour": "naca4415", "chord": 0.3, "skin": 0.001, "webs": [0.2, 0.5]},
}
AREAS = {
    "rectangle": 0.06 * 0.015,
    "strip": 0.06 * 0.002,
    "split-rectangle": 0.1 * 0.08,
    "ellipse": pi * 0.02 * 0.01,
    "tube": pi * (0.1**2 - 0.09**2),
    "box": 0.03 * 0.02 - (0.03 - 0.003) * (0.02 - 0.0025),
    "two-cell": 0.05 * 0.02 - 0.048 * 0.018 + 0.001 * 0.018,
    "i": 0.1 * 0.01 + 0.08 * 0.01 + 0.18 * 0.006,
    "channel": 0.0015 * (0.025 + 0.0105 + 0.0235),
}


def library(name: str, refine: int = 0, **sizes: Any) -> SectionMesh:
    spec = expand(name, {**SIZES[name], **sizes})
    return section_mesh(spec, f"{name}.mesh", refine=refine)


def moments(mesh: SectionMesh) -> Array:
    """Area, first and second moments by quadrature on the cells' own map."""
    ((kind, _),), (corners,) = mesh.cells.of_kinds, mesh.cells.shapes
    points, weights = fenicsx.quadrature(CELL_KINDS[kind], 8)
    values, slopes = full_basis(kind, points)
    x, y = np.moveaxis(values @ corners, -1, 0)
    jacobian = np.einsum("cka,qkg->cqag", corners, slopes)
    dA = weights * np.abs(np.linalg.det(jacobian))
    return np.array([np.sum(dA * f) for f in (1.0, x, y, x * x, y * y, x * y)])


def nodes_of(mesh: SectionMesh, region: str) -> Array:
    """Nodes of the cells of a region, (c, k, 2)."""
    (corners,) = mesh.cells.shapes
    return corners[mesh.cells.region == mesh.cells.regions.index(region)]


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
    assert set(mesh.cells.regions) == {wall.region for wall in SHAPES[name].walls}
    assert mesh.warnings == ()


@pytest.fixture
def repository_root() -> Path:
    return Path(__file__).resolve().parent.parent.parent


@pytest.mark.parametrize("name", SHAPES)
def test_refinement(name: str) -> None:
    """Four times the cells, the same regions, and the area closer to the exact one."""
    coarse, fine = library(name), library(name, refine=1)
    assert fine.cells.n_cell == 4 * coarse.cells.n_cell
    assert fine.cells.regions == coarse.cells.regions
    for row, region in enumerate(coarse.cells.regions):
        count = np.count_nonzero(coarse.cells.region == row)
        assert np.count_nonzero(fine.cells.region == row) == 4 * count, region
    if name in AREAS:
        error = [abs(moments(mesh)[0] / AREAS[name] - 1.0) for mesh in (coarse, fine)]
        assert error[1] < error[0] / 8 or error[1] < 1e-13


def test_refined_arcs_stay_on_their_circle() -> None:
    nodes = nodes_of(library("tube", refine=2), "wall").reshape(-1, 2)
    radius = np.hypot(*nodes.T)
    # two rows by default: their faces are curves of the script; new rows lie between
    for face in (0.09, 0.095, 0.1):
        near = np.abs(radius - face) < 1e-5
        assert np.count_nonzero(near) > 100
        assert np.abs(radius[near] - face).max() < 1e-13
    rows = np.linspace(0.09, 0.1, 17)
    assert np.abs(radius[:, None] - rows).min(axis=1).max() < 1e-6


def test_thin_curved_rows_do_not_fold_when_refined(tmp_path: Path) -> None:
    """A tube of 16 plies, radius 200 times the wall; as a script of the library and of a user."""
    spec = expand("tube", {"outer_radius": 0.1, "wall": 0.0005}, {"wall": [1.0] * 16})
    for refine in (0, 1):
        mesh = section_mesh(spec, "tube", refine=refine)
        assert mesh.warnings == ()
        assert moments(mesh)[0] == pytest.approx(pi * (0.1**2 - 0.0995**2), rel=1e-5)
    ring = library("tube")
    for script in (Path(__file__).resolve().parents[2] / "meshes").glob("*.geo"):
        shutil.copy(script, tmp_path)
    user = {"file": str(tmp_path / "tube.geo"), "parameters": spec["parameters"]}
    assert section_mesh(user, "tube", refine=1).cells.n_cell == 4 * 36 * 16
    assert ring.cells.regions == section_mesh(user, "tube").cells.regions


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


AIRFOILS: dict[str, dict[str, Any]] = {
    "no web": {"webs": []},
    "one thick web": {"webs": [0.3], "web": 0.004},
    "two webs": {},
    "three webs": {"webs": [0.15, 0.3, 0.6]},
    "thick caps": {"cap": 0.004},
    "thin caps": {"skin": 0.002, "cap": 0.001},
    "thin rear": {"skin": 0.002, "skin_rear": 0.0005},
    "thicker than the nose is round": {"contour": "naca0012", "skin": 0.006, "skin_rear": 0.001},
    "as thick as the nose is round": {"contour": "naca0012", "skin": 0.0047, "skin_rear": 0.001},
    "other origin": {"origin": 0.25},
}


@pytest.mark.parametrize("change", AIRFOILS.values(), ids=AIRFOILS.keys())
def test_airfoil(change: dict[str, Any]) -> None:
    """Whole, without slivers, and every node of the skin on a row at its depth."""
    sizes = {**SIZES["airfoil"], **change}
    spec = expand("airfoil", sizes)
    mesh = section_mesh(spec, "airfoil.mesh")
    assert mesh.warnings == ()
    assert set(mesh.cells.regions) == {wall.region for wall in walls("airfoil", sizes)}
    faces = np.concatenate([[0.0], spec["parameters"]["faces"]])
    rows = np.sort(np.concatenate([faces, 0.5 * (faces[:-1] + faces[1:])]))
    key = {"skin": "skin_front", "skin-front": "skin_front", "skin-rear": "skin_rear"}
    for region in mesh.cells.regions:
        if region.startswith("web"):
            continue
        x = nodes_of(mesh, region).reshape(-1, 2)
        depth = np.linalg.norm(nearest_on_curve(mesh.curves["outer"], x) - x, axis=1)
        thickness = spec["parameters"][key.get(region, "cap")]
        assert depth.max() == pytest.approx(thickness, rel=5e-4)
        off_row = np.abs(depth[:, None] - rows).min(axis=1)
        assert off_row.max() < 5e-4 * thickness


def test_webs_stand_where_they_are_asked_for() -> None:
    mesh = library("airfoil", webs=[0.25, 0.6], web=[0.002, 0.003], origin=0.1)
    for name, place, wall in (("web-1", 0.25, 0.002), ("web-2", 0.6, 0.003)):
        x = nodes_of(mesh, name)[..., 0]
        middle = 0.3 * (place - 0.1)
        assert [x.min(), x.max()] == pytest.approx([middle - wall / 2, middle + wall / 2])


def test_blunt_trailing_edge_is_kept() -> None:
    """A trailing edge thicker than its skins is not cut off."""
    outline = np.array(expand("airfoil", SIZES["airfoil"])["coordinates"])
    outline[:, 1] += np.where(np.arange(len(outline)) < len(outline) / 2, 1, -1) * (
        0.03 * outline[:, 0]
    )
    sharp = library("airfoil")
    blunt = library("airfoil", contour=outline.tolist())
    assert 0.27 < nodes_of(sharp, "skin-rear")[..., 0].max() < 0.295
    assert nodes_of(blunt, "skin-rear")[..., 0].max() == pytest.approx(0.3, abs=1e-4)
    assert np.ptp(blunt.curves["outer"][..., 0]) == pytest.approx(0.3, abs=3e-4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"skin": 0.025}, "skin_rear = 0.025: too thick, no hollow"),
        ({"webs": [0.3, 0.98]}, "webs: the last one lies behind"),
        ({"skin": 0.012, "webs": [0.03, 0.5], "skin_rear": 0.001}, "webs: .* no room"),
        ({"skin": 0.012, "skin_rear": 0.001}, "skin_front = 0.012: too thick for the nose"),
    ],
)
def test_airfoils_that_cannot_be(change: dict[str, Any], message: str) -> None:
    with pytest.raises(SectionError, match=f"airfoil.py: {message}"):
        section_mesh(expand("airfoil", {**SIZES["airfoil"], **change}), "airfoil.mesh")


# A quarter of a ring, inner radius 1, outer 2: two regions, the outer arc named.
RING = """
DefineConstant[ n = {4, Name "Parameters/n"} ];
Mesh.ElementOrder = ORDER;
Mesh.SecondOrderIncomplete = INCOMPLETE;
Point(1) = {0, 0, 0};
For k In {0:2}
  Point(10 + k) = {Cos(k * Pi / 4), Sin(k * Pi / 4), 0};
  Point(20 + k) = {2 * Cos(k * Pi / 4), 2 * Sin(k * Pi / 4), 0};
  Line(30 + k) = {10 + k, 20 + k};
EndFor
For k In {0:1}
  Circle(10 + k) = {10 + k, 1, 11 + k};
  Circle(20 + k) = {20 + k, 1, 21 + k};
  Curve Loop(k + 1) = {30 + k, 20 + k, -(31 + k), -(10 + k)};
  Plane Surface(k + 1) = {k + 1};
  Transfinite Surface {k + 1};
  RECOMBINE
EndFor
Transfinite Curve {10, 11, 20, 21, 30, 31, 32} = n + 1;
Physical Surface("low") = {1};
Physical Surface("high") = {2};
Physical Curve("outer") = {20, 21};
"""
KINDS: dict[str, dict[str, Any]] = {
    "triangle": {"ORDER": 1, "INCOMPLETE": 0, "RECOMBINE": ""},
    "triangle6": {"ORDER": 2, "INCOMPLETE": 0, "RECOMBINE": ""},
    "quad": {"ORDER": 1, "INCOMPLETE": 0, "RECOMBINE": "Recombine Surface {k + 1};"},
    "quad8": {"ORDER": 2, "INCOMPLETE": 1, "RECOMBINE": "Recombine Surface {k + 1};"},
    "quad9": {"ORDER": 2, "INCOMPLETE": 0, "RECOMBINE": "Recombine Surface {k + 1};"},
}


def ring_text(kind: str) -> str:
    text = RING
    for word, value in KINDS[kind].items():
        text = text.replace(word, str(value))
    return text


def ring(folder: Path, kind: str) -> Path:
    path = folder / f"{kind}.geo"
    path.write_text(ring_text(kind))
    return path


def saved(script: Path, target: Path, **options: float) -> Path:
    """Mesh a script with gmsh and save it, as a user would."""
    with fenicsx.gmsh_session():
        gmsh.clear()
        gmsh.merge(str(script))
        gmsh.model.mesh.generate(2)
        for name, value in options.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        gmsh.write(str(target))
        gmsh.clear()
    return target


@pytest.mark.parametrize("kind", KINDS)
def test_user_script_and_saved_mesh_agree(kind: str, tmp_path: Path) -> None:
    script = ring(tmp_path, kind)
    by_script = section_mesh({"file": str(script)}, "ring")
    degree = 2 if kind[-1].isdigit() else 1
    assert by_script.cells.degree == degree
    assert set(by_script.cells.regions) == {"low", "high"}
    segments = by_script.curves["outer"]
    assert segments.shape == (8, degree + 1, 2)
    assert np.hypot(*segments.reshape(-1, 2).T) == pytest.approx(2.0)
    for version, binary in ((2.2, 0), (4.1, 0), (4.1, 1)):
        path = saved(script, tmp_path / f"{kind}.msh", MshFileVersion=version, Binary=binary)
        by_file = section_mesh({"file": str(path)}, "ring")
        assert by_file.cells.n_cell == by_script.cells.n_cell
        assert moments(by_file) == pytest.approx(moments(by_script), rel=1e-12)
        assert by_file.curves.keys() == {"outer"}
        for region in ("low", "high"):
            centre = [nodes_of(m, region).mean(axis=(0, 1)) for m in (by_file, by_script)]
            assert centre[0] == pytest.approx(centre[1])


@pytest.mark.parametrize("kind", KINDS)
def test_refinement_of_a_script_and_of_its_mesh(kind: str, tmp_path: Path) -> None:
    """Refinement of a script follows its geometry; a mesh keeps its shape and its moments."""
    script = ring(tmp_path, kind)
    path = saved(script, tmp_path / f"{kind}.msh")
    exact = pi * (4 - 1) / 4
    areas = [moments(section_mesh({"file": str(script)}, "x", refine=r))[0] for r in range(3)]
    errors = np.abs(np.array(areas) / exact - 1.0)
    order = 2 if KINDS[kind]["ORDER"] == 1 else 4
    assert np.all(np.log2(errors[:-1] / errors[1:]) > order - 0.3)

    base = section_mesh({"file": str(path)}, "x")
    for refine in (1, 2):
        mesh = section_mesh({"file": str(path)}, "x", refine=refine)
        assert mesh.cells.n_cell == 4**refine * base.cells.n_cell
        assert moments(mesh) == pytest.approx(moments(base), rel=1e-12, abs=1e-12)
        assert mesh.curves["outer"].shape[0] == 2**refine * base.curves["outer"].shape[0]
        ends = mesh.curves["outer"].reshape(-1, 2)
        on_base = nearest_on_curve(base.curves["outer"], ends)
        assert np.abs(on_base - ends).max() < 1e-9
        assert mesh.warnings == ()


def test_eight_and_nine_nodes_make_the_same_section(tmp_path: Path) -> None:
    eight, nine = (section_mesh({"file": str(ring(tmp_path, k))}, "x") for k in ("quad8", "quad9"))
    assert moments(eight) == pytest.approx(moments(nine), rel=1e-4)


def test_parameters_lists_and_scale(tmp_path: Path) -> None:
    script = ring(tmp_path, "quad9")
    fine = section_mesh({"file": str(script), "parameters": {"n": 8}}, "x")
    assert fine.cells.n_cell == 2 * 8 * 8
    small = section_mesh({"file": str(script), "scale": 1e-3}, "x")
    plain = section_mesh({"file": str(script)}, "x")
    scales = np.array([2, 3, 3, 4, 4, 4])
    assert moments(small) == pytest.approx(moments(plain) * 1e-3**scales, rel=1e-12)
    assert small.curves["outer"] == pytest.approx(1e-3 * plain.curves["outer"])
    with pytest.raises(SectionError, match="no parameter m"):
        section_mesh({"file": str(script), "parameters": {"m": 8}}, "x")


def test_script_with_a_macro_is_read_again_and_again(tmp_path: Path) -> None:
    """gmsh reads a Macro once in a process."""
    path = tmp_path / "macro.geo"
    path.write_text(
        'DefineConstant[ a = {1, Name "Parameters/a"} ];\nMacro Side\n'
        "  l[] = Extrude {a, 0, 0} { Point{1}; Layers{2}; };\nReturn\n"
        "Point(1) = {0, 0, 0};\nCall Side;\n"
        "s[] = Extrude {0, 1, 0} { Line{l[1]}; Layers{2}; Recombine; };\n"
        'Physical Surface("body") = {s[1]};\nPhysical Curve("foot") = {l[1]};\n'
    )
    for a in (1.0, 2.0, 3.0):
        mesh = section_mesh({"file": str(path), "parameters": {"a": a}}, "x")
        assert moments(mesh)[0] == pytest.approx(a)
        assert np.ptp(mesh.curves["foot"][..., 0]) == pytest.approx(a)


def test_arrays(tmp_path: Path) -> None:
    """Arrays in the form that the solver writes for meshes of other programs."""
    path = tmp_path / "part.npz"
    np.savez(
        path,
        points=[[0.0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1], [5, 5]],
        cells=[[0, 1, 2, 3], [1, 4, 5, 2]],
        cell_type="quad",
        region=[1, 0],
        region_names=["right", "left"],
        lines=[[0, 1], [1, 4]],
        curve=[0, 0],
        curve_names=["foot"],
    )
    mesh = section_mesh({"arrays": str(path), "scale": 2.0}, "part")
    assert nodes_of(mesh, "left")[..., 0].max() == 2.0
    assert mesh.curves["foot"].shape == (2, 2, 2)
    assert moments(mesh)[0] == pytest.approx(8.0)
    assert section_mesh({"arrays": str(path)}, "part", refine=1).cells.n_cell == 8


def test_equal_requests_share_a_mesh_until_the_file_changes(tmp_path: Path) -> None:
    script = ring(tmp_path, "quad")
    first = section_mesh({"file": str(script)}, "x")
    assert section_mesh({"file": str(script)}, "another section") is first
    script.write_text(ring_text("quad9"))
    assert section_mesh({"file": str(script)}, "x").cells.degree == 2
