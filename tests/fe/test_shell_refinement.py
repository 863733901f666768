"""Finer meshes of a shell: the same surface, regions and named nodes, four cells for one."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.shell_specs import SCRIPTS, plate

from plymotion.preprocess.fenicsx import NamedNodes, PlainMesh
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.shell_cells import ShellError, ShellMesh
from plymotion.preprocess.shell.shell_mesh import mesh_of, shell_mesh, split
from plymotion.solver.package.common import cells as tables
from plymotion.solver.package.common.cells import NONE

pytestmark = pytest.mark.one_end
ROOF = {"n_length": 4, "n_around": 6}


def copied(folder: Path, name: str) -> Path:
    """A script of the library as a script of the user."""
    for file in (name, "grid.py"):
        shutil.copy(SCRIPTS / file, folder / file)
    return folder / name


def meshes(file: Path, **options: Any) -> tuple[ShellMesh, ShellMesh]:
    """A mesh and the finer one."""
    spec = {"file": str(file), "parameters": ROOF, **options}
    return shell_mesh(spec, "mesh"), shell_mesh({**spec, "refine": 1}, "mesh")


@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_a_script_of_the_library_gets_more_cells(element: str) -> None:
    coarse, fine = meshes(SCRIPTS / "cylinder.py", element=element)
    assert len(fine.cells) == 4 * len(coarse.cells)
    assert np.hypot(*fine.points_G[:, 1:].T) == pytest.approx(25.0)  # all on the cylinder
    assert {n: len(c) for n, c in fine.curves.items()} == {
        n: 2 * len(c) for n, c in coarse.curves.items()
    }


@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_cells_of_other_meshes_are_split(element: str, tmp_path: Path) -> None:
    coarse, fine = meshes(copied(tmp_path, "cylinder.py"), element=element)
    assert len(fine.cells) == 4 * len(coarse.cells)
    assert fine.area_vectors_G.sum(axis=0) == pytest.approx(coarse.area_vectors_G.sum(axis=0))
    assert len(np.unique(fine.node_tags)) == fine.n_node
    for name, curve in coarse.curves.items():
        assert len(fine.curves[name]) == 2 * len(curve)
        found, known = (m.points_G[m.curves[name]] for m in (fine, coarse))
        assert np.linalg.norm(found[:, 1] - found[:, 0], axis=1).sum() == pytest.approx(
            np.linalg.norm(known[:, 1] - known[:, 0], axis=1).sum()
        )
    for name, nodes in coarse.marks.items():
        assert fine.points_G[fine.marks[name]] == pytest.approx(coarse.points_G[nodes])


def test_triangles_and_quadrilaterals_of_one_mesh() -> None:
    """Cells keep their region and sense; a curve across a cell keeps its segment."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], dtype=float)
    cells = np.array([[0, 1, 2, 3], [1, 4, 2, NONE]])
    curves = {"side": np.array([[4, 1], [1, 2]]), "across": np.array([[0, 2]])}
    marks = {"corner": np.array([4]), "edge": np.array([2, 1, 4]), "face": np.arange(4)}
    named = NamedNodes(np.arange(1, 6), curves, marks)
    plain = PlainMesh(points, cells, "mixed", 1, np.array([0, 1]), ("a", "b"), {}, named)
    found = split(mesh_of(plain))
    assert found.region.tolist() == [0] * 4 + [1] * 4
    assert tables.corner_counts(found.cells).tolist() == [4] * 4 + [3] * 4
    areas = found.area_vectors_G
    np.testing.assert_allclose(areas, [[0, 0, 0.25]] * 4 + [[0, 0, 0.125]] * 4, atol=1e-15)
    assert len(np.unique(found.points_G, axis=0)) == found.n_node == len(found.node_tags)
    side = found.points_G[found.curves["side"]]
    assert side[:, :, :2].tolist() == [
        [[2, 0], [1.5, 0]],
        [[1.5, 0], [1, 0]],
        [[1, 0], [1, 0.5]],
        [[1, 0.5], [1, 1]],
    ]
    assert found.curves["across"].tolist() == [[0, 2]]
    # an edge by its nodes, as in decks of Abaqus: only every second node of it was held
    added = {
        name: found.points_G[rows[len(marks[name]) :], :2].tolist()
        for name, rows in found.marks.items()
    }
    assert added["corner"] == []
    assert sorted(added["edge"]) == [[1, 0.5], [1.5, 0], [1.5, 0.5]]
    assert sorted(added["face"]) == [[0, 0.5], [0.5, 0], [0.5, 0.5], [0.5, 1], [1, 0.5]]


def test_split_cells_converge_as_those_of_the_script(tmp_path: Path) -> None:
    """Frequencies of a plate: split cells are those that the script makes."""
    spec = plate(4, 0.02, supports={"root": {"at": "left", "fixed": "all"}})
    spec |= {"frequencies": {"count": 4}}
    found = []
    for file in (SCRIPTS / "plate.py", copied(tmp_path, "plate.py")):
        spec["mesh"] = {**spec["mesh"], "file": str(file), "element": "quadrilateral", "refine": 1}
        modes = analyse(spec).modes
        assert modes is not None
        found.append(modes.frequencies)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9)


@pytest.mark.parametrize("wrong", [-1, 0.5, True])
def test_a_wrong_count_is_refused(wrong: Any) -> None:
    with pytest.raises(ShellError, match=r"mesh\.refine = .*: expected an integer of at least 0"):
        shell_mesh({"file": str(SCRIPTS / "plate.py"), "refine": wrong}, "mesh")
