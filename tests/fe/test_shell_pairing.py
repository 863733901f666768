"""Triangles as quadrilaterals on request: which pairs are better, what is told of the rest."""

from pathlib import Path
from typing import Any

import pytest
from samples.shell_meshes import gmsh_file
from samples.shell_obstacle_course import straight_beam
from samples.shell_specs import plate

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.solver.package.common.cells import corner_counts
from plymotion.solver.report.shell.findings import shell_json

pytestmark = pytest.mark.one_end
QUADS = {"element": "quadrilateral"}
LONG = 0  # parameter `diagonals` of the scripts: one way
RHOMBI = """
import numpy as np

def build(gmsh, parameters):
    geo, n, angle = gmsh.model.geo, int(parameters["n"]), np.radians(parameters["angle_deg"])
    ends = ((0, 0), (1, 0), (1 + np.cos(angle), np.sin(angle)), (np.cos(angle), np.sin(angle)))
    corners = [geo.addPoint(x, y, 0) for x, y in ends]
    lines = [geo.addLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    for line in lines:
        geo.mesh.setTransfiniteCurve(line, n + 1)
    geo.mesh.setTransfiniteSurface(surface, parameters["diagonals"])
    if parameters["recombine"]:
        geo.mesh.setRecombine(2, surface)
    geo.synchronize()
    for dim, tag, name in ((2, surface, "plate"), (1, lines[3], "left"), (1, lines[1], "right")):
        gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, [tag]), name)
"""


def rhombus(tmp_path: Path, diagonals: str = "Left", **mesh: Any) -> dict[str, Any]:
    """8 x 8 rhombi of 30 degrees, held at one side and pulled across at the other."""
    (tmp_path / "rhombi.py").write_text(RHOMBI)
    parameters = {"n": 8, "angle_deg": 30.0, "diagonals": diagonals, "recombine": False}
    return plate(
        1,
        0.01,
        mesh={"file": str(tmp_path / "rhombi.py"), "parameters": parameters, **QUADS, **mesh},
        supports={"left": {"at": "left", "fixed": "all"}},
        loads={"F": {"tip": {"at": "right", "force": [1.0, 0.0, 0.0]}}},
    )


def told(warnings: Any) -> list[str]:
    return [w["message"] for w in warnings if w["code"] == "triangles-not-paired"]


def test_parallelograms_of_30_degrees_carry_bending_in_their_plane() -> None:
    """Triangles of their long diagonals have 0.18 of the deflection."""
    model, _ = straight_beam((6, 1), "in")
    model.mesh |= {"slant": 0.1732, "slant_alternates": 0, "diagonals": LONG}
    ratios = {}
    for name, cells in (("triangles", {}), ("quadrilaterals", QUADS)):
        solved = analyse(
            {**model.spec(cells=cells), "probes": {"tip": {"at": "right", "what": "uy"}}}
        )
        ratios[name] = float(solved.probes.values[0, 0] / 0.1081)
    assert ratios["triangles"] < 0.2
    assert 0.8 < ratios["quadrilaterals"] < 1.0


def test_long_diagonals_of_rhombi_are_removed(tmp_path: Path) -> None:
    for diagonals in ("Left", "Right"):
        found = analyse(rhombus(tmp_path, diagonals))
        table = shell_json(found)
        assert told(found.warnings) == []
        assert table["quadrilaterals"] >= 56
        assert table["triangles"] + 2 * table["quadrilaterals"] == 128
        assert table["triangles"] + table["quadrilaterals"] == table["cells"]


@pytest.mark.provokes("triangles-not-paired")
def test_what_stays_is_told_with_the_reason_and_advice_clears_it(tmp_path: Path) -> None:
    spec = rhombus(tmp_path, "Alternate")
    found = analyse(spec)
    table = shell_json(found)
    (message,) = told(found.warnings)
    assert "triangles-not-paired" in {w["code"] for w in found.warnings}
    assert f"{table['triangles']} of 128 triangles" in message
    assert "no better than their own" in message
    assert "Recombine Surface" in message
    assert 0 < table["quadrilaterals"] <= 40
    # once more after a refinement: the share is that of the mesh of the file
    assert told(ShellProblem({**spec, "mesh": {**spec["mesh"], "refine": 1}}).warnings) == [message]
    spec["mesh"]["parameters"]["recombine"] = True
    found = analyse(spec)
    assert (corner_counts(found.mesh.cells) == 4).all()
    assert told(found.warnings) == []


def test_the_better_of_both_cells_is_taken(tmp_path: Path) -> None:
    """Displacement of the loaded side over that of 64 x 64 triangles of short diagonals."""
    spec = rhombus(tmp_path)
    spec["mesh"]["parameters"]["n"] = 64
    del spec["mesh"]["element"]
    (exact,) = analyse(spec).cases.energy
    for diagonals in ("Left", "Right", "Alternate"):
        errors = []
        for cells in ({}, QUADS):
            spec = rhombus(tmp_path, diagonals)
            del spec["mesh"]["element"]
            spec["mesh"] |= cells
            errors.append(abs(analyse(spec).cases.energy[0] / exact - 1.0))
        assert errors[1] < errors[0]


def test_estimates_of_cells_that_err_both_ways(tmp_path: Path) -> None:
    """Some cells are too soft, others too stiff: their errors cancel on one mesh, not on others."""

    def cases(diagonals: str, n: int) -> Any:
        spec = rhombus(tmp_path, diagonals)
        spec["mesh"]["parameters"]["n"] = n
        spec["supports"]["right"] = {"at": "right", "fixed": "all"}
        spec["loads"] = {"p": {"all": {"pressure": 1.0}}}
        return analyse(spec).cases

    exact = float(cases("Left", 48).energy[0])
    for diagonals, n in (("Alternate", 8), ("Alternate", 12), ("Right", 12)):
        found = cases(diagonals, n)
        error, true = float(found.error[0]), float(found.energy[0]) / exact - 1.0
        assert abs(error - true) < 0.04, (diagonals, n, error, true)


def test_triangles_beside_quadrilaterals_are_paired(tmp_path: Path) -> None:
    """Not across the foot of a rib, whose cells would lose their side."""
    points = [[x, y, 0.0] for x in range(3) for y in range(2)] + [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0]]
    cells = [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3], [2, 3, 7, 6]]
    file = gmsh_file(tmp_path / "rib.msh", points, cells, "skin")
    mesh = ShellProblem(plate(1, 0.1, mesh={"file": file, **QUADS})).mesh
    assert corner_counts(mesh.cells).tolist() == [4, 4, 4]


def test_sides_on_physical_curves_stay(tmp_path: Path) -> None:
    """A stiffener along the diagonal of two triangles needs it as a side."""
    points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    cells, rib = [[0, 1, 2], [0, 2, 3]], {"rib": [[2, 0]]}
    file = gmsh_file(tmp_path / "square.msh", points, cells, "skin", rib)
    mesh = ShellProblem(plate(1, 0.1, mesh={"file": file, **QUADS})).mesh
    assert corner_counts(mesh.cells).tolist() == [3, 3]
    assert "physical curve" in mesh.unpaired.reason
