"""motion.vtkhdf in ParaView's reader: sections, positions and strength ratios of a run."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from peers.ply_stresses import body_strength
from samples.case_samples import short_run
from samples.vtk_samples import Player

from plymotion.solver.__main__ import main
from plymotion.solver.math.disk_cache import file_sha256
from plymotion.solver.math.rotations import rotation_matrix
from plymotion.solver.package import read_package
from plymotion.solver.package.common.container import get_text
from plymotion.solver.package.common.files import has_right_seal
from plymotion.solver.results import RunResult, read_result

RADIUS, WALL, LENGTH = 0.025, 6 * 0.125e-3, 0.6  # m, of the upper arm


@pytest.fixture(scope="module")
def folder(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The robot arm, 0.2 s of it, with its animation."""
    made = tmp_path_factory.mktemp("case")
    short_run(repository, "robot-arm", "base", made, 0.2, signals={})
    case = json.loads((made / "case.json").read_text())
    (made / "case.json").write_text(json.dumps(case | {"figures": {}}))
    assert main(["report", str(made), "--vtk"]) == 0
    return made


@pytest.fixture(scope="module")
def result(folder: Path) -> RunResult:
    return read_result(folder / "base/result.vtkhdf")


@pytest.fixture(scope="module")
def player(folder: Path) -> Player:
    return Player(folder / "base/motion.vtkhdf")


def test_points_are_where_modal_coordinates_put_them(player: Player, result: RunResult) -> None:
    assert len(player.times) == min(len(result.t), 200)
    np.testing.assert_array_equal(player.times[[0, -1]], result.t[[0, -1]])
    for step in (0, len(player.times) // 2, len(player.times) - 1):
        grid = player.at(step)
        row = int(np.argmin(np.abs(result.t - player.times[step])))
        for number, body in enumerate(result.bodies):
            view = body.view
            assert view is not None
            first, m = view.first_position, len(view.shapes_B)
            r, p = result.q[row, first : first + 3], result.q[row, first + 3 : first + 7]
            moved = np.einsum("m,mna->na", result.q[row, first + 7 : first + 7 + m], view.shapes_B)
            node, offset = view.surface.node, view.surface.offset_B
            u = moved[node, :3] + np.cross(moved[node, 3:], offset)
            A = rotation_matrix(p / np.linalg.norm(p))
            expected = (r + (body.nodes_B[node] + offset + u) @ A.T)[view.surface.triangles]
            own = grid.extract_cells(np.flatnonzero(grid.cell_data["body_id"] == number))
            corners = own.points[own.cell_connectivity.reshape(-1, 3)]
            np.testing.assert_allclose(corners, expected, rtol=0, atol=1e-6)


def test_beams_have_their_real_section(player: Player, result: RunResult) -> None:
    """The upper arm is a tube about the x axis of its frame."""
    grid = player.at(0)
    view = result.bodies[0].view
    assert view is not None
    r, p = np.split(result.q[0, view.first_position :][:7], [3])
    own = grid.extract_cells(np.flatnonzero(grid.cell_data["body_id"] == 0))
    rest = (own.points - r) @ rotation_matrix(p) - own.point_data["displacement"]
    radii = np.linalg.norm(rest[:, 1:], axis=1)
    # Outlines come from integration points: 0.25 % too large with cells of 10 degrees.
    assert radii.max() == pytest.approx(RADIUS, rel=0.003)
    assert np.ptp(radii) == pytest.approx(WALL, rel=0.01)
    ends = rest[:, [0]]
    assert (ends.min(), ends.max()) == pytest.approx((0.0, LENGTH), abs=1e-6)


def test_strength_ratio_is_that_of_all_points_of_the_section(
    folder: Path, player: Player, result: RunResult
) -> None:
    table = json.loads((folder / "runs/base.json").read_text())["packages"]
    for step in (len(player.times) // 3, len(player.times) - 1):
        grid = player.at(step)
        row = int(np.argmin(np.abs(result.t - player.times[step])))
        for number, body in enumerate(result.bodies):
            assert body.view is not None
            package = read_package(folder / table[body.name]["file"])
            first = body.view.first_position + 7
            q = result.q[row : row + 1, first : first + package.n_mode]
            exact = body_strength(package, result.t[row : row + 1], q)
            assert exact is not None
            ratio = np.asarray(grid.cell_data["strength_ratio"])
            lowest = np.nanmin(ratio[grid.cell_data["body_id"] == number])
            # Governing points only (docs/report.md): never below, and at most 0.5 % above.
            assert 1.0 - 1e-6 < lowest / exact.governing.ratio < 1.005


def test_strain_energy_is_that_of_the_modes(player: Player, result: RunResult) -> None:
    step = len(player.times) - 1
    grid = player.at(step)
    for number, body in enumerate(result.bodies):
        view = body.view
        assert view is not None
        assert view.sites is not None
        q = result.q[-1, view.first_position + 7 :][: len(view.shapes_B)]
        F = view.sites.resultants_E @ q
        density = 0.5 * np.einsum("si,sij,sj->s", F, view.sites.compliance[view.sites.kind], F)
        own = np.asarray(grid.cell_data["strain_energy"])[grid.cell_data["body_id"] == number]
        assert own.max() == pytest.approx(density.max(), rel=1e-6)
        corner = view.surface.site
        part = corner.min(axis=1) >= 0  # not the sphere of a point mass, which has no stress
        assert part.sum() > 1000
        np.testing.assert_allclose(own[part], density[corner[part]].max(axis=1), rtol=1e-5)
        assert not own[~part].any()


def test_the_file_tells_units_names_and_where_it_comes_from(folder: Path) -> None:
    file = folder / "base/motion.vtkhdf"
    with h5py.File(file) as opened:
        grid = opened["VTKHDF"]
        assert json.loads(get_text(grid["CellData/body_id"], "names")) == ["upper", "fore"]
        assert get_text(grid["Points"], "unit") == "m"
        assert get_text(grid["CellData/strength_ratio"], "unit") == "-"
        assert get_text(opened, "result_sha256") == file_sha256(folder / "base/result.vtkhdf")
        provenance = json.loads(get_text(opened, "provenance"))
        assert provenance["versions"]["plymotion"]
        assert set(provenance["packages"]) == {"upper", "fore"}
    assert has_right_seal(file)
