"""Meshes that would give plausible but wrong numbers give errors or warnings."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx import gmsh
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.section_warnings import coarse_warnings
from plymotion.preprocess.section.space.section_mesh import SectionMesh, section_mesh
from plymotion.preprocess.section.timoshenko import tension_centre
from plymotion.solver.inputs.section.shapes.library import SHAPES, expand

ISOTROPIC = {"kind": "isotropic", "E": 1.0, "nu": 0.3, "rho": 1.0}


def squares(*places: tuple[float, float], n: tuple[int, ...] = ()) -> str:
    """Unit squares side by side as gmsh text, without common nodes: surfaces s1, s2, ..."""
    text = "Geometry.AutoCoherence = 0;\n"
    for k, (x, y) in enumerate(places, start=1):
        points, lines = 10 * k, 10 * k
        corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        for i, (a, b) in enumerate(corners):
            text += f"Point({points + i}) = {{{a}, {b}, 0}};\n"
        for i in range(4):
            text += f"Line({lines + i}) = {{{points + i}, {points + (i + 1) % 4}}};\n"
        loop = ", ".join(str(lines + i) for i in range(4))
        cells = n[k - 1] if n else 2
        text += (
            f"Curve Loop({k}) = {{{loop}}};\nPlane Surface({k}) = {{{k}}};\n"
            f"Transfinite Curve {{{loop}}} = {cells + 1};\n"
            f"Transfinite Surface {{{k}}};\nRecombine Surface {{{k}}};\n"
        )
    return text


def groups(**tags: str) -> str:
    return "".join(f'Physical Surface("{name}") = {{{tag}}};\n' for name, tag in tags.items())


Mesher = Callable[..., SectionMesh]


@pytest.fixture
def mesh(tmp_path: Path) -> Mesher:
    """mesh(text): the section of a gmsh script, by itself or, with `save`, by its saved mesh."""

    def make(text: str, save: float = 0.0, **options: float) -> SectionMesh:
        path = tmp_path / "part.geo"
        path.write_text(text)
        if save:
            with fenicsx.gmsh_session():
                gmsh.clear()
                gmsh.merge(str(path))
                gmsh.model.mesh.generate(2)
                gmsh.option.setNumber("Mesh.MshFileVersion", save)
                for name, value in options.items():
                    gmsh.option.setNumber(f"Mesh.{name}", value)
                path = path.with_suffix(".msh")
                gmsh.write(str(path))
                gmsh.clear()
        return section_mesh({"file": str(path)}, "part.mesh")

    return make


def cells_file(path: Path, nodes: Any, cells: Any, *kinds: int) -> Path:
    """A mesh in gmsh's format 2.2 by hand, one physical surface "body"; one kind, or one a cell."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    lines += ["$PhysicalNames", "1", '2 1 "body"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(nodes))]
    lines += [f"{i} {x} {y} {z[0] if z else 0}" for i, (x, y, *z) in enumerate(nodes, start=1)]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    for i, cell in enumerate(cells, start=1):
        kind = kinds[i - 1] if kinds[1:] else kinds[0]
        lines.append(f"{i} {kind} 2 1 1 " + " ".join(str(node + 1) for node in cell))
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return path


def by_hand(folder: Path, nodes: Any, cells: Any, kind: int) -> SectionMesh:
    path = cells_file(folder / "part.msh", nodes, cells, kind)
    return section_mesh({"file": str(path)}, "part.mesh")


def codes(mesh: SectionMesh) -> list[str]:
    return [warning["code"] for warning in mesh.warnings]


SOUND = squares((0, 0)) + groups(body="1")


@pytest.mark.one_end
def test_a_sound_mesh_passes(mesh: Mesher) -> None:
    assert codes(mesh(SOUND)) == []
    assert mesh(SOUND).cells.n_cell == 4


def test_cells_of_two_degrees_in_a_surface(tmp_path: Path) -> None:
    """gmsh takes the degree of the first for that of all: its arrays were too short."""
    nodes = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1), (1.5, 0), (2, 0.5), (1.5, 1)]
    nodes += [(1, 0.5), (1.5, 0.5)]
    mixed = {3: [0, 1, 2, 3], 10: [1, 4, 5, 2, 6, 7, 8, 9, 10]}
    for kinds in ((3, 10), (10, 3)):
        path = cells_file(tmp_path / "part.msh", nodes, [mixed[k] for k in kinds], *kinds)
        with pytest.raises(SectionError, match="mixes cells of degree 1 and 2"):
            section_mesh({"file": str(path)}, "part.mesh")


# parts


@pytest.mark.one_end
def test_parts_apart(mesh: Mesher) -> None:
    text = squares((0, 0), (3, 0), (6, 0)) + groups(flange="1", web="2, 3")
    with pytest.raises(SectionError, match=r"in 3 parts without a common edge: flange from \(0, 0"):
        mesh(text)


@pytest.mark.one_end
def test_parts_that_are_not_merged(mesh: Mesher) -> None:
    """Side by side with nodes at the same positions: the most frequent mistake."""
    text = squares((0, 0), (1, 0)) + groups(left="1", right="2")
    with pytest.raises(SectionError, match=r"in 2 parts.*3 pairs of nodes.*\(1, .*Coherence"):
        mesh(text)
    assert codes(mesh(text + "Coherence;\n")) == []


@pytest.mark.one_end
def test_parts_whose_nodes_do_not_match(mesh: Mesher) -> None:
    text = squares((0, 0), (1.0, 0.25), n=(2, 3)) + groups(left="1", right="2")
    with pytest.raises(SectionError, match=r"in 2 parts.*nodes must be the same.*BooleanFragments"):
        mesh(text)


@pytest.mark.one_end
def test_parts_that_touch_in_one_node(mesh: Mesher) -> None:
    text = squares((0, 0), (1, 1)) + "Coherence;\n" + groups(low="1", high="2")
    with pytest.raises(SectionError, match=r"in 2 parts.*single nodes, as at \(1, 1\).*hinge"):
        mesh(text)


@pytest.mark.provokes("unmerged-nodes")
def test_a_slit_is_warned_of(mesh: Mesher, tmp_path: Path) -> None:
    """Three squares around a corner, the fourth side left open by nodes of its own."""
    nodes = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (0, 2), (1, 2), (2, 2), (2, 1)]
    cells = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 9, 8, 7)]
    slit = by_hand(tmp_path, nodes, cells, 3)
    assert codes(slit) == ["unmerged-nodes"]
    assert "at (2, 1)" in slit.warnings[0]["message"]
    merged = [tuple(5 if node == 9 else node for node in cell) for cell in cells]
    assert codes(by_hand(tmp_path, nodes[:9], merged, 3)) == []


@pytest.mark.provokes("cells-overlap")
def test_skins_over_each_other(tmp_path: Path) -> None:
    """Two sides of a trailing edge with common nodes at the nose only, which is on the left."""
    nodes = [(-1, 1), (-1, 0), (-1, -1), (0, 1), (0, 0), (0, -1)]
    nodes += [(1, 1), (1, -0.7), (2, 1), (2, -0.7), (1, 0.7), (1, -1), (2, 0.7), (2, -1)]
    cells = [(1, 4, 3, 0), (2, 5, 4, 1), (4, 7, 6, 3), (7, 9, 8, 6), (5, 11, 10, 4)]
    wedge = by_hand(tmp_path, nodes, [*cells, (11, 13, 12, 10)], 3)
    assert codes(wedge) == ["cells-overlap"]


# cells


def test_clockwise_cells_are_turned(tmp_path: Path) -> None:
    """The direction of numbering of cells does not change results, in all or in some cells."""
    nodes = [(x, y) for y in (0, 0.5, 1, 1.5, 2) for x in (0, 0.5, 1, 1.5, 2)]

    def nine(i: int, j: int) -> list[int]:
        steps = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))
        return [5 * (j + b) + i + a for a, b in steps]

    cells = [nine(i, j) for i in (0, 2) for j in (0, 2)]
    turned = [[cell[k] for k in (0, 3, 2, 1, 7, 6, 5, 4, 8)] for cell in cells]
    K = []
    for table in (cells, turned, cells[:2] + turned[2:]):
        path = cells_file(tmp_path / "part.msh", nodes, table, 10)
        spec = {
            "name": "square",
            "mesh": {"file": str(path)},
            "materials": {"m": ISOTROPIC},
            "regions": {"body": {"plies": [{"material": "m", "angle_deg": 0.0}]}},
        }
        assert codes(section_mesh(spec["mesh"], "x")) == []
        K.append(analyse(spec, estimate=False).K)
    assert np.abs(K[1] - K[0]).max() < 1e-12
    assert np.abs(K[2] - K[0]).max() < 1e-12


def test_folded_cell(tmp_path: Path) -> None:
    """A middle node moved through the cell."""
    nodes = [(0, 0), (1, 0), (0, 1), (0.5, 0.45), (0.5, 0.5), (0, 0.5)]
    with pytest.raises(SectionError, match=r"1 of 1 cells are folded.*\(0.3333, 0.3333\).*'body'"):
        by_hand(tmp_path, nodes, [range(6)], 9)


def test_quadrilateral_with_crossed_corners(tmp_path: Path) -> None:
    with pytest.raises(SectionError, match="are folded"):
        by_hand(tmp_path, [(0, 0), (1, 0), (0, 1), (1, 1)], [range(4)], 3)


def test_node_dragged_over_a_neighbour(tmp_path: Path) -> None:
    """The cells have an area, but one is inverted on top of the others."""
    nodes = [(0, 0), (2, 0), (2, 2), (0, 2), (3, 1)]
    cells = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    with pytest.raises(SectionError, match=r"cells overlap at .*cell is inverted"):
        by_hand(tmp_path, nodes, cells, 2)


def test_cell_without_area(tmp_path: Path) -> None:
    nodes = [(0, 0), (1, 0), (0, 1), (1, 1), (0.5, 0.5)]
    cells = [(0, 1, 2), (1, 3, 2), (1, 4, 2)]
    with pytest.raises(SectionError, match=r"1 of 3 cells have no area, one at \(0.5, 0.5\)"):
        by_hand(tmp_path, nodes, cells, 2)


@pytest.mark.parametrize("slope", [0.1, 1 / 3, 0.7])
def test_area_that_is_rounding_is_no_fold(slope: float, tmp_path: Path) -> None:
    """Six nodes on a slanted line: at the points of integration the area has either sign."""
    nodes = [(x, slope * x) for x in (0.1, 1.1, 0.7, 0.6, 0.9, 0.4)]
    with pytest.raises(SectionError, match="1 of 1 cells have no area"):
        by_hand(tmp_path, nodes, [range(6)], 9)


@pytest.mark.provokes("sliver-elements")
@pytest.mark.parametrize(
    ("nodes", "cells", "kind"),
    [
        ([(0, 0), (1, 0), (0.5, 0.01), (0.5, 1)], [(0, 1, 2), (0, 2, 3), (1, 3, 2)], 2),
        ([(0, 0), (1, 0), (1.9, 0.02), (0.9, 0.02)], [(0, 1, 2, 3)], 3),
        ([(0, 0), (1, 0), (1, 1), (0.499, 0.51)], [(0, 1, 2, 3)], 3),
        ([(0, 0), (1, 0), (1, 5e-7), (0, 5e-7)], [(0, 1, 2, 3)], 3),
    ],
    ids=["flat triangle", "skewed", "nearly a triangle", "needle"],
)
def test_slivers_are_warned_of(nodes: Any, cells: Any, kind: int, tmp_path: Path) -> None:
    sliver = by_hand(tmp_path, nodes, cells, kind)
    assert codes(sliver) == ["sliver-elements"]
    assert "in region 'body'" in sliver.warnings[0]["message"]


@pytest.mark.parametrize("height", [1e-4, 1e-6])
def test_thin_strips_are_no_slits_and_no_slivers(height: float) -> None:
    """Rows of 6e-8 of the width: their nodes are near, but not at the same place."""
    assert codes(section_mesh(expand("rectangle", {"width": 1.0, "height": height}), "strip")) == []


def test_a_coordinate_that_is_no_number_is_named(tmp_path: Path) -> None:
    nodes = [(0, 0), (1, 0), (1, 1), (float("nan"), 1)]
    with pytest.raises(SectionError, match=r"node 4 at \[nan, 1.0.*expected finite coordinates"):
        by_hand(tmp_path, nodes, [(0, 1, 2, 3)], 3)
    path = tmp_path / "part.npz"
    np.savez(
        path, points=nodes, cells=[range(4)], cell_type="quad", region=[0], region_names=["body"]
    )
    with pytest.raises(SectionError, match=r"node 4 at \[nan, 1.0\]: expected finite"):
        section_mesh({"arrays": str(path)}, "part.mesh")


BOUNDED = """DefineConstant[ density = {1, Name "Parameters/density"} ];
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 1, 0.1};
Mesh.MeshSizeMax = 0.05 / density;
Physical Surface("all") = {1};
"""


@pytest.mark.parametrize("density", [1e3, 1e9])
def test_a_script_that_asks_for_too_many_cells(tmp_path: Path, density: float) -> None:
    path = tmp_path / "strip.geo"
    path.write_text(BOUNDED)
    made = section_mesh({"file": str(path), "parameters": {"density": 2.0}}, "x")
    assert 200 < made.cells.n_cell < 1000
    with pytest.raises(SectionError, match=r"strip.geo.*density = .*1000000"):
        section_mesh({"file": str(path), "parameters": {"density": density}}, "x")


THIN: dict[str, dict[str, Any]] = {
    "rectangle": {"width": 0.06, "height": 0.0005},
    "strip": {"width": 0.0005, "height": 0.06},
    "split-rectangle": {"width": 0.1, "height": 0.001, "interface": 0.04},
    "ellipse": {"radius_2": 0.02, "radius_3": 0.002},
    "tube": {"outer_radius": 0.1, "wall": 0.0002, "span_deg": 200.0},
    "box": {"width": 0.3, "height": 0.1, "wall": 0.0005, "wall_left": 0.005},
    "two-cell": {"width": 0.3, "height": 0.1, "web_position": 0.14, "wall": 0.0005},
    "i": {"height": 0.5, "top_width": 0.1, "wall": 0.02, "wall_web": 0.001},
    "polyline": {
        "x2": [0.1, 0.0, 0.0, 0.2],
        "x3": [0.3, 0.3, 0.0, 0.05],
        "wall": [0.001, 0.001, 0.01],
    },
    "channel": {"height": 0.3, "top_width": 0.01, "bottom_width": 0.2, "wall": 0.001},
    "airfoil": {"contour": "naca0012", "chord": 1.0, "skin": 0.001, "webs": [0.15, 0.5]},
}


@pytest.mark.one_end
@pytest.mark.parametrize("name", SHAPES)
def test_thin_graded_cells_of_the_library_are_no_slivers(name: str) -> None:
    for density in (0.5, 1.0):
        spec = expand(name, {**THIN[name], "density": density})
        assert codes(section_mesh(spec, name)) == []


# the second lost 0.07 of its torsion without a word
@pytest.mark.one_end
@pytest.mark.parametrize(
    ("height", "distance", "twist"),
    [(0.5, 1e4, None), (0.01, 1e3, None), (0.5, 1e13, None), (0.5, 1e4, 1e-6), (0.5, 1e3, None)],
)
def test_a_distant_origin_is_the_cause(
    height: float, distance: float, twist: float | None, tmp_path: Path
) -> None:
    """A section of width 1."""
    x, y = np.array([0.6, 0.8]) * distance
    nodes = [(x + a, y + b * height) for b in (0, 0.5, 1) for a in (0, 0.5, 1)]
    file = cells_file(tmp_path / "a.msh", nodes, [[0, 2, 8, 6, 1, 5, 7, 3, 4]], 10)
    spec: dict[str, Any] = {"name": "bar", "mesh": {"file": str(file)}}
    spec |= {"materials": {"m": ISOTROPIC}}
    spec |= {"regions": {"body": {"plies": [{"material": "m", "angle_deg": 0.0}]}}}
    spec |= {} if twist is None else {"initial_curvature": [twist, 0.0, 0.0]}
    if height * distance == 0.5e3:
        centre = tension_centre(analyse(spec, estimate=False).K)
        np.testing.assert_allclose(centre, [x + 0.5, y + 0.5 * height], rtol=1e-6)
        return
    with pytest.raises(SectionError, match=r"away from the origin of its mesh.*move the mesh"):
        analyse(spec, estimate=False)


# regions


@pytest.mark.one_end
def test_surface_in_two_groups(mesh: Mesher) -> None:
    text = squares((0, 0), (1, 0)) + "Coherence;\n" + groups(skin="1, 2", spar="2")
    message = r"surface 2, from \(1, .*is in 2 physical groups: 'skin' and 'spar'; expected exactly"
    for save in (0.0, 4.1):
        with pytest.raises(SectionError, match=message):
            mesh(text, save)


def test_cells_in_two_groups_of_an_old_file(mesh: Mesher) -> None:
    """Format 2.2 repeats a cell for each of its groups."""
    text = squares((0, 0), (1, 0)) + "Coherence;\n" + groups(skin="1, 2", spar="2")
    with pytest.raises(SectionError, match=r"('skin' and 'spar'|two physical groups)"):
        mesh(text, 2.2)


@pytest.mark.one_end
def test_cells_without_group(mesh: Mesher) -> None:
    text = squares((0, 0), (1, 0)) + "Coherence;\n" + groups(left="1")
    for save in (0.0, 4.1):
        with pytest.raises(SectionError, match=r"surface 2, from \(1, 0\).*in 0 physical groups"):
            mesh(text, save, SaveAll=1) if save else mesh(text)
    # the old format loses every group then
    with pytest.raises(SectionError, match=r"no physical surface.*no Mesh.SaveAll when saving"):
        mesh(text, 2.2, SaveAll=1)


@pytest.mark.one_end
def test_no_group_at_all(mesh: Mesher) -> None:
    for save in (0.0, 4.1, 2.2):
        with pytest.raises(SectionError, match=r"no physical surface, expected one for each reg"):
            mesh(squares((0, 0)), save)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_two_groups_of_one_name(version: float, mesh: Mesher, tmp_path: Path) -> None:
    """gmsh does not write such a file, and reads it without the second name."""
    text = squares((0, 0), (1, 0)) + "Coherence;\n" + groups(skin="1", web="2")
    assert set(mesh(text, version).cells.regions) == {"skin", "web"}
    path = tmp_path / "part.msh"
    path.write_text(path.read_text().replace('"web"', '"skin"'))
    with pytest.raises(SectionError, match=r"two physical surfaces, 1 and 2, are named 'skin'"):
        section_mesh({"file": str(path)}, "part.mesh")


def test_group_without_cells(tmp_path: Path) -> None:
    path = tmp_path / "part.msh"
    with fenicsx.gmsh_session():
        gmsh.clear()
        for tag, name in ((1, "body"), (2, "ghost")):
            gmsh.model.addDiscreteEntity(2, tag)
            gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [tag]), name)
        gmsh.model.mesh.addNodes(2, 1, [1, 2, 3], [0, 0, 0, 1, 0, 0, 0, 1, 0])
        gmsh.model.mesh.addElementsByType(1, 2, [], [1, 2, 3])
        gmsh.write(str(path))
        gmsh.clear()
    with pytest.raises(SectionError, match="physical surface 'ghost' has no cells"):
        section_mesh({"file": str(path)}, "part.mesh")


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["body", "ghost"], "region 'ghost' has no cells"),
        (["body", "body"], r"region_names = .*expected each name once"),
    ],
)
def test_regions_of_arrays(names: list[str], message: str, tmp_path: Path) -> None:
    path = tmp_path / "part.npz"
    table = {"points": [[0.0, 0], [1, 0], [0, 1]], "cells": [[0, 1, 2]], "region": [0]}
    np.savez(path, cell_type="triangle", region_names=names, **table)
    with pytest.raises(SectionError, match=message):
        section_mesh({"arrays": str(path)}, "part.mesh")


@pytest.mark.one_end
def test_group_without_a_name_is_called_by_its_number(mesh: Mesher) -> None:
    text = squares((0, 0)) + "Physical Surface(7) = {1};\n"
    for save in (0.0, 4.1, 2.2):
        assert set(mesh(text, save).cells.regions) == {"7"}


# kinds of cells and files


def test_mixed_cells(mesh: Mesher) -> None:
    text = squares((0, 0), (1, 0)).replace("Recombine Surface {2};", "")
    text += "Coherence;\n" + groups(left="1", right="2")
    cells = mesh(text).cells
    assert np.bincount(cells.kind).tolist() == [8, 4]
    with pytest.raises(SectionError, match=r"mixes 8 triangles and 4 quadrilaterals.*degree 1"):
        mesh("Mesh.ElementOrder = 2;\n" + text)


def test_cubic_cells(mesh: Mesher) -> None:
    with pytest.raises(SectionError, match=r"expected triangles or quadrilaterals of degree 1 or"):
        mesh(SOUND + "Mesh.ElementOrder = 3;\n")


def test_solid_mesh(tmp_path: Path) -> None:
    path = tmp_path / "part.msh"
    with fenicsx.gmsh_session():
        gmsh.clear()
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [1])
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
        gmsh.clear()
    with pytest.raises(SectionError, match=r"has solid \(3-D\) cells"):
        section_mesh({"file": str(path)}, "part.mesh")


def test_mesh_of_curves_only(mesh: Mesher) -> None:
    text = "Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Line(1) = {1, 2};"
    with pytest.raises(SectionError, match="has no surface cells"):
        mesh(text)


@pytest.mark.parametrize("z", [(1e-3, 0, 0), (1, 1, 1)])
def test_off_the_plane(z: tuple[float, ...], tmp_path: Path) -> None:
    nodes = [(0, 0, z[0]), (1, 0, z[1]), (0, 1, z[2])]
    with pytest.raises(SectionError, match=r"is not in the plane z = 0; a section is meshed with"):
        by_hand(tmp_path, nodes, [range(3)], 2)


@pytest.mark.parametrize(
    "mistake",
    ["Point(1) = {0, 0, ;", 'DefineConstant[ n = {4}, Name "x"} ];', "If(1)\n Point(1) = {,};\n"],
)
def test_a_script_after_one_with_a_mistake(mistake: str, mesh: Mesher) -> None:
    """gmsh keeps the rest of a faulty script in its parser, which would affect the next script."""
    with pytest.raises(SectionError, match="syntax error"):
        mesh(mistake + "\n" + SOUND)
    assert mesh(f"// after {mistake!r}\n" + SOUND).cells.n_cell == 4


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ({"file": "nowhere.msh"}, r"part.mesh.file = 'nowhere.msh': no such file"),
        ({"arrays": "nowhere.npz"}, r"part.mesh.arrays = 'nowhere.npz': no such file"),
        ({"script": "boks"}, "gmsh script boks: not found"),
        ({}, "part.mesh: expected one of script, file, arrays, found none"),
        ({"script": "box", "file": "x"}, "found script and file"),
    ],
)
def test_no_such_mesh(spec: dict[str, Any], message: str) -> None:
    with pytest.raises(SectionError, match=message):
        section_mesh(spec, "part.mesh")


def test_no_mesh_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "part.msh"
    path.write_text("this is no mesh\n")
    with pytest.raises(SectionError, match=r"part\.msh"):
        section_mesh({"file": str(path)}, "part.mesh")


@pytest.mark.one_end
@pytest.mark.parametrize(
    ("mesh", "advice"),
    [
        ({"script": "box", "parameters": {"density": 1.0}}, "a larger density or a higher"),
        ({"script": "box", "degree": "mesh"}, "a larger density"),
        ({"file": "own.msh"}, "a finer mesh in the file or a higher mesh.degree"),
        ({"file": "own.geo", "degree": "mesh"}, "a finer mesh in the file"),
        ({"arrays": "own.npz", "degree": "mesh"}, "a finer mesh in the file"),
    ],
)
def test_words_of_a_coarse_mesh(mesh: dict[str, Any], advice: str) -> None:
    """They name --accuracy, and the density of those meshes only that have one."""
    error = 0.06 * np.diag([0.0, 1.0, 2.0, 0.0, 0.0, 0.0])
    (warning,) = coarse_warnings(error, np.eye(6), mesh)
    assert warning["code"] == "coarse-mesh"
    first = "the estimated error of K33 is 0.12 of sqrt(K_ii K_jj): use --accuracy, "
    assert warning["message"].startswith(first + advice)
    assert ("density" in warning["message"]) == ("script" in mesh)
    assert ("mesh.degree" in warning["message"]) == ("degree" not in mesh)
    assert coarse_warnings(error / 3.0, np.eye(6), mesh) == []
    assert coarse_warnings(None, np.eye(6), mesh) == []


def test_an_error_as_large_as_the_stiffness_leaves_no_digit() -> None:
    """A twisted strip of t/b = 1e-4 with a field of degree 2: K44 is 3 to 98 times too large."""
    words = "no digit is right and K may be too large by any factor"
    for error, lost in ((0.98, False), (1.0, True)):
        (warning,) = coarse_warnings(error * np.eye(6), np.eye(6), {})
        assert (words in warning["message"]) == lost
