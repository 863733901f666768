"""Meshes of half the cell size: on the surface, with all groups."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.cylinder_samples import write_cylinder
from samples.shell_specs import SCRIPTS, plate

from plymotion.preprocess.shell.analyses import discretisation
from plymotion.preprocess.shell.analyses.discretisation import refined
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.shell_cells import ShellMesh
from plymotion.preprocess.shell.shell_mesh import shell_mesh

# No DOLFINx function is called but that of the numbering, which all tests of shells call.
pytestmark = pytest.mark.one_end


def area(mesh: ShellMesh) -> float:
    return float(np.linalg.norm(mesh.area_vectors_G, axis=1).sum())


@pytest.mark.parametrize("triangles", [False, True])
def test_new_nodes_lie_on_a_cylinder(triangles: bool, tmp_path: Path) -> None:
    file = write_cylinder(tmp_path / "c.msh", 1.0, 1.0, (4, 9), 90.0, triangles=triangles)
    mesh = shell_mesh({"file": str(file)}, "mesh")
    fine = refined(mesh).mesh
    chord = 1.0 - np.cos(np.pi / 36.0)
    away = np.abs(np.linalg.norm(fine.points_G[:, 1:], axis=1) - 1.0)
    assert away.max() < 0.03 * chord  # at the edges as well
    assert area(fine) - 0.5 * np.pi == pytest.approx((area(mesh) - 0.5 * np.pi) / 4.0, rel=0.2)
    assert len(fine.cells) == 4 * len(mesh.cells)
    for name, curve in mesh.curves.items():
        assert len(fine.curves[name]) == 2 * len(curve)
    ends = fine.points_G[fine.curves["near"]]
    assert np.abs(ends[1:, 0] - ends[:-1, 1]).max() == 0.0  # in the order and sense of the curve
    assert np.array_equal(fine.marks["corner"], mesh.marks["corner"])
    assert np.einsum("ci,ci->c", fine.area_vectors_G, fine.centres_G * [0, 1, 1]).min() > 0.0


@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_walls_that_meet_at_an_edge_stay_flat(element: str) -> None:
    size = {"n_length": 3, "n_width": 2, "n_height": 1}
    request: dict[str, Any] = {"file": str(SCRIPTS / "box-beam.py"), "parameters": size}
    mesh = shell_mesh({**request, "element": element}, "mesh")
    found = refined(mesh)
    assert area(found.mesh) == pytest.approx(area(mesh), rel=1e-12)
    straight = found.from_coarse @ mesh.points_G
    assert found.mesh.points_G == pytest.approx(straight, abs=1e-12 * mesh.size)
    parts = [np.bincount(m.region, weights=np.linalg.norm(m.area_vectors_G, axis=1))
             for m in (mesh, found.mesh)]  # fmt: skip
    assert parts[1] == pytest.approx(parts[0], rel=1e-12)


def test_a_mesh_that_is_too_large_gets_no_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = plate((4, 2), 0.01, supports={"root": {"at": "left", "fixed": "all"}})
    spec["loads"] = {"push": {"tip": {"at": "right", "force": [-1.0, 0.0, 0.0]}}}
    spec["buckling"] = {"count": 1, "error": True}
    spec["frequencies"] = {"count": 1, "error": True}
    known = analyse(spec)
    assert known.buckling is not None
    assert known.modes is not None
    assert known.buckling.error is not None
    assert known.modes.error is not None
    monkeypatch.setattr(discretisation, "MOST", 6 * 45 - 1)  # 9 x 5 nodes
    without = analyse(spec)
    assert without.buckling is not None
    assert without.modes is not None
    assert without.buckling.error is None
    assert without.modes.error is None
