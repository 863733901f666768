"""What a shell analysis refuses or warns of: mechanisms, meshes, elements that do not fit."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.shell_meshes import gmsh_file
from samples.shell_specs import CFRP, HARD, METAL, box, mesh_from, plate

from plymotion.preprocess.__main__ import main
from plymotion.preprocess.laminate.stiffness import LaminateError
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError
from plymotion.preprocess.shell.shell_mesh import shell_mesh

Record = Callable[[str, Any], None]
PRESS = {"press": {"all": {"pressure": 1.0}}}
CLAMPED = {"root": {"at": "left", "fixed": "all"}}


def codes(problem: Any) -> list[str]:
    return [warning["code"] for warning in problem.warnings]


def metal(mesh: Any, h: float = 0.01, **tables: Any) -> ShellProblem:
    """An isotropic shell on a mesh of arrays."""
    spec = {
        "mesh": {"file": "arrays"},
        "materials": {"metal": METAL},
        "regions": {"all": {"material": "metal", "thickness": h}},
        **tables,
    }
    return ShellProblem(spec, mesh=mesh)


@pytest.mark.parametrize(
    ("fixed", "words"),
    [
        (
            ["uz"],
            ["4 rigid motions", "translation along x; translation along y", "about y", "about z"],
        ),
        (["ux", "uy", "uz", "rx", "rz"], ["1 rigid motions", "rotation about y through (0, "]),
    ],
)
def test_loose_shells_say_how_they_move(fixed: list[str], words: list[str]) -> None:
    held = {"held": {"at": "left", "fixed": fixed}}
    with pytest.raises(ShellError) as caught:
        analyse(plate(3, 0.01, supports=held, loads=PRESS))
    for word in words:
        assert word in str(caught.value)


def test_axis_of_a_loose_motion_of_a_tiny_shell() -> None:
    """Coordinates are rounded to the size of the shell, not to a length in metres."""
    held = {"held": {"at": "right", "fixed": ["ux", "uy", "uz", "rx", "rz"]}}
    with pytest.raises(ShellError, match=r"rotation about y through \(1e-10, "):
        analyse(plate(3, 1e-13, 1e-10, 1e-10, supports=held, loads=PRESS))


@pytest.mark.one_end
@pytest.mark.parametrize("thickness", [1e-2, 1e-4, 1e-6])
def test_rigid_motions_of_a_thin_shell_have_no_energy(thickness: float) -> None:
    """What rounding leaves of them is up to 1e-4 of the lowest elastic value, of either sign."""
    found = analyse(plate(20, thickness, frequencies={"count": 3, "free": True}))
    assert found.modes is not None
    assert found.modes.n_zero == 6
    assert codes(found) == []
    assert (found.modes.frequencies[:6] == 0.0).all()
    # of a free square plate, (w L^2) sqrt(rho h / D) = 13.47 at nu = 0.3
    D_over_mass = METAL["E"] * thickness**2 / (12 * (1 - METAL["nu"] ** 2) * METAL["rho"])
    expected = 13.47 * np.sqrt(D_over_mass) / (2 * np.pi)
    assert found.modes.frequencies[6] / (2 * np.pi) == pytest.approx(expected, rel=2e-2)


def test_no_supports_at_all() -> None:
    with pytest.raises(ShellError, match="6 rigid motions are free"):
        analyse(plate(3, 0.01, loads=PRESS))


@pytest.mark.provokes("drilling-fictitious-flat", "zero-energy-modes")
def test_fictitious_drilling_on_a_flat_plate(record: Record) -> None:
    """The paper's matrix has the null vector (1, 1, 1): a seventh mode of 0 Hz."""
    paper = {"membrane": "cst", "drilling": "fictitious"}
    free = {"count": 3, "free": True}
    found = analyse(plate(6, 0.01, elements=paper, frequencies=free))
    assert found.modes is not None
    assert found.modes.n_zero == 7
    assert {"drilling-fictitious-flat", "zero-energy-modes"} <= set(codes(found))
    record("shell fictitious modes", found.modes.frequencies[7:])
    tied = analyse(plate(6, 0.01, elements={"membrane": "cst"}, frequencies=free))
    assert tied.modes is not None
    assert tied.modes.n_zero == 6
    assert not {"drilling-fictitious-flat", "zero-energy-modes"} & set(codes(tied))
    hard = {
        name: {**support, "fixed": [f for f in support["fixed"] if f != "rz"]}
        for name, support in HARD.items()
    }
    with pytest.raises(ShellError, match="rotation of all nodes about the normal"):
        analyse(plate(4, 0.01, elements=paper, supports=hard, loads=PRESS))
    hard["corner"] = {"at": "corner-00", "fixed": ["rz"]}
    assert analyse(plate(4, 0.01, elements=paper, supports=hard, loads=PRESS)).cases.energy[0] > 0
    # walls that meet at kinks hold each other
    folded = analyse(box(elements=paper, loads=PRESS, frequencies=free))
    assert folded.modes is not None
    assert folded.modes.n_zero == 6


@pytest.mark.provokes("sliver")
def test_slivers() -> None:
    mesh = mesh_from([[0, 0, 0], [1, 0, 0], [0.5, 0.01, 0], [0.5, 1, 0]], [[0, 1, 2], [2, 1, 3]])
    problem = metal(mesh)
    assert codes(problem) == ["sliver"]
    assert "1 of 2 cells" in problem.warnings[0]["message"]
    assert codes(ShellProblem(plate(4, 0.01))) == []


@pytest.mark.provokes("normals-disagree")
def test_reversed_normals_and_t_junctions() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.5, 0.5, 1]]
    good = mesh_from(points[:4], [[0, 1, 2], [1, 3, 2]], [0, 1])
    bad = mesh_from(points[:4], [[0, 1, 2], [1, 2, 3]], [0, 1])
    junction = mesh_from(points, [[0, 1, 2], [1, 2, 3], [1, 2, 4]], [0, 1, 1])
    assert codes(metal(good)) == []
    assert codes(metal(bad)) == ["normals-disagree"]
    assert codes(metal(junction)) == []
    regions = {"all": {"material": "metal", "thickness": 0.01}}
    flipped = {**regions, "s2": {**regions["all"], "flip": True}}
    assert codes(metal(bad, regions=flipped)) == []
    assert codes(metal(good, regions=flipped)) == ["normals-disagree"]


def test_a_surface_that_is_there_twice(tmp_path: Path) -> None:
    """As gmsh's format 2 writes what is in two groups: it was as stiff and heavy as two."""
    path = tmp_path / "twice.msh"
    lines = [
        "$MeshFormat",
        "2.2 0 8",
        "$EndMeshFormat",
        "$PhysicalNames",
        "2",
        '2 1 "a"',
        '2 2 "b"',
    ]
    lines += ["$EndPhysicalNames", "$Nodes", "4", "1 0 0 0", "2 1 0 0", "3 1 1 0", "4 0 1 0"]
    lines += ["$EndNodes", "$Elements", "2", "1 3 2 1 1 1 2 3 4", "2 3 2 2 2 2 3 4 1"]
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    with pytest.raises(ShellError, match="1 cells have the corners of another one"):
        shell_mesh({"file": str(path)}, "mesh")


@pytest.mark.provokes("nodes-not-merged", "several-parts")
def test_parts_that_touch_without_common_nodes() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert codes(metal(mesh_from(points, [[0, 1, 2], [3, 4, 5]]))) == ["nodes-not-merged"]
    apart = [*points[:3], *([x + 1, y, z] for x, y, z in points[3:])]
    ends = {"a": [[0, 1]], "b": [[3, 4]]}
    mesh = mesh_from(apart, [[0, 1, 2], [3, 4, 5]], **ends)
    assert codes(metal(mesh)) == ["several-parts"]


def test_parts_that_touch_in_one_node() -> None:
    """A link that joins both makes them one part."""
    points = [[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [2, 0, 0], [1.5, 1, 0]]
    mesh = mesh_from(points, [[0, 1, 2], [1, 3, 4]], tips=[[2, 4]])
    (warning,) = metal(mesh).warnings
    assert warning["code"] == "several-parts"
    assert "touch in 1 single nodes, one at (1, 0, 0)" in warning["message"]
    assert not codes(metal(mesh, links={"tips": {"at": "tips", "kind": "rigid"}}))
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]]  # three cells at a side
    assert not codes(metal(mesh_from(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])))


def test_regions_without_laminate() -> None:
    spec = box()
    del spec["regions"]["left"]
    with pytest.raises(ShellError, match="surface 'left' of the mesh has no laminate"):
        ShellProblem(spec)
    spec["regions"]["lfet"] = spec["regions"]["top"]
    with pytest.raises(ShellError, match="did you mean 'left'"):
        ShellProblem(spec)


@pytest.mark.one_end
def test_nodes_of_no_cell(tmp_path: Path) -> None:
    script = tmp_path / "stray.py"
    script.write_text(
        "def build(gmsh, parameters):\n"
        "    surface = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)\n"
        "    stray = gmsh.model.occ.addPoint(3, 0, 0)\n"
        "    gmsh.model.occ.synchronize()\n"
        "    gmsh.model.addPhysicalGroup(2, [surface])\n"
        "    group = gmsh.model.addPhysicalGroup(0, [stray])\n"
        "    gmsh.model.setPhysicalName(0, group, 'stray')\n"
    )
    with pytest.raises(ShellError, match="1 nodes of physical group 'stray' belong to no cell"):
        ShellProblem(plate(1, 0.1, mesh={"file": str(script)}))


def test_script_that_fails(tmp_path: Path) -> None:
    """The script, its line and the cause, not a defect of the program."""
    script = tmp_path / "wrong.py"
    script.write_text("def build(gmsh, parameters):\n    gmsh.model.no_such_function()\n")
    with pytest.raises(
        ShellError, match=r"wrong.py: build.* line 2 with AttributeError: .*no_such"
    ):
        ShellProblem(plate(1, 0.1, mesh={"file": str(script)}))


@pytest.mark.one_end
@pytest.mark.provokes("cst-in-plane-bending", "dst-thick")
def test_elements_that_lock_or_do_not_converge() -> None:
    paper = {"membrane": "cst", "plate": "dst"}
    assert codes(ShellProblem(box((40, 1, 1), elements=paper))) == ["cst-in-plane-bending"]
    assert codes(ShellProblem(box((40, 4, 4), elements={"membrane": "cst"}))) == []
    assert codes(ShellProblem(box((40, 1, 1)))) == []
    assert codes(ShellProblem(plate(8, 0.1, elements={"plate": "dst"}))) == ["dst-thick"]
    assert codes(ShellProblem(plate(8, 1e-3, elements={"plate": "dst"}))) == []
    assert codes(ShellProblem(plate(8, 0.1))) == []


def test_laminate_findings_are_passed_on() -> None:
    assert "laminate-unsymmetric" in codes(analyse(box((4, 1, 1), frequencies={"count": 1})))


def test_supports_on_links() -> None:
    links = {"tip": {"at": "tip", "kind": "rigid"}}
    with pytest.raises(ShellError, match="fixes ux of a node of a rigid link"):
        ShellProblem(box(links=links, supports={"s": {"at": "tip-top", "fixed": ["ux"]}}))
    average = {"tip": {"at": "tip", "kind": "average"}}
    with pytest.raises(ShellError, match="average link follows its group"):
        ShellProblem(box(links=average, supports={"s": {"at": "tip", "fixed": "all"}}))
    with pytest.raises(ShellError, match="shares a node with the rigid link 'tip'"):
        ShellProblem(box(links={**links, "b": {"at": "tip-top", "kind": "rigid"}}))
    held = analyse(box(links=links, supports={"s": {"at": "tip", "fixed": "all"}}, loads=PRESS))
    assert np.abs(held.cases.link_motions_G).max() == 0.0
    assert held.cases.reactions_G[0, 0, :3] == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.one_end
def test_command_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_text(json.dumps(plate(3, 0.01, supports=CLAMPED, loads=PRESS)))
    bad.write_text(json.dumps(plate(3, 0.01, loads=PRESS)))
    assert main(["shell", str(good), str(bad)]) == 2
    out, err = capfd.readouterr()
    assert out == "[1/2] good: 96 dofs\n"
    assert "bad.json: supports: 6 rigid motions are free" in err
    assert main(["shell", str(good)]) == 0
    assert capfd.readouterr().out == "[1/1] good: unchanged\n"
    assert main(["shell", str(good), str(bad), "--out", "x.vtkhdf"]) == 2


def test_messages_name_node_and_key() -> None:
    with pytest.raises(ShellError, match=r"node 3 at \[0.0, nan, 0.0\]: expected three finite"):
        mesh_from([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]])
    across = {"all": {"material": "metal", "thickness": 0.01, "axis": [0.0, 0.0, 1.0]}}
    fault = r"8 of 8 triangles: each is normal to its reference direction; the first has the nodes"
    with pytest.raises(ShellError, match=rf"regions.all.axis: {fault} \d+, \d+, \d+, at \(0"):
        ShellProblem(plate(2, 0.01, regions=across))


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("materials", "E1", 9e29),
        ("materials", "G12", 9e29),
        ("laminates", "offset", 9e29),
        ("laminates", "offset", -9e29),
    ],
)
def test_a_laminate_that_is_singular_to_rounding_is_named(
    table: str, key: str, value: float
) -> None:
    plies = [{"material": "cfrp", "angle_deg": a, "thickness": 1e-3} for a in (30.0, 0.0)]
    laminate = {"plies": [*plies, {"material": "metal", "thickness": 1e-3}]}
    spec = plate(2, 0.1, laminates={"skin": laminate})
    spec["materials"] = {"cfrp": dict(CFRP), "metal": METAL}
    spec["regions"] = {"all": {"laminate": "skin", "axis": [1.0, 0.0, 0.0]}}
    spec["supports"] = {"left": {"at": "left", "fixed": "all"}}
    spec["loads"] = {"pull": {"tip": {"at": "right", "force": [1.0, 0.0, 0.0]}}}
    (spec["materials"]["cfrp"] if table == "materials" else laminate)[key] = value
    with pytest.raises((LaminateError, ShellError), match="singular"):
        analyse(spec)


@pytest.mark.parametrize("value", [1e31, -1.7e308])
def test_coordinates_whose_products_are_no_numbers(tmp_path: Path, value: float) -> None:
    corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [value, 1.0, 0.0]]
    file = gmsh_file(tmp_path / "far.msh", corners, [[0, 1, 2]], "skin")
    with pytest.raises(ShellError, match=r"node 3 at .*: expected three finite coordinates of at"):
        ShellProblem(plate(1, 0.1, mesh={"file": file}))
