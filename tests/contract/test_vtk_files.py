"""ParaView's reader (VTK through PyVista) opens packages and plays results."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.package_samples import cantilever
from samples.result_samples import crowd, swinging_rod
from samples.vtk_samples import Player, grid_of

from plymotion.solver.package import write_package
from plymotion.solver.results import write_result


def test_package_opens_with_its_modes(tmp_path: Path) -> None:
    package = cantilever()
    write_package(tmp_path / "arm.vtkhdf", package)
    grid = grid_of(tmp_path / "arm.vtkhdf")
    np.testing.assert_array_equal(grid.points, package.nodes_B)
    np.testing.assert_array_equal(grid.cell_connectivity, package.connectivity)
    np.testing.assert_array_equal(grid.celltypes, package.cell_types)
    for i in range(package.n_mode):
        np.testing.assert_array_equal(
            grid.point_data[f"mode_{i + 1:03d}_shape"], package.shapes_B[i, :, :3]
        )
        np.testing.assert_array_equal(
            grid.point_data[f"mode_{i + 1:03d}_rotation"], package.shapes_B[i, :, 3:]
        )


def test_view_of_a_package_stores_nothing_twice(tmp_path: Path) -> None:
    write_package(tmp_path / "arm.vtkhdf", cantilever())
    with h5py.File(tmp_path / "arm.vtkhdf") as h5:
        for view, ours in (("Points", "nodes_B"), ("Types", "cell_types")):
            assert h5[f"VTKHDF/{view}"] == h5[f"modal_package/mesh/{ours}"]
        assert all(d.is_virtual for d in h5["VTKHDF/PointData"].values())


@pytest.mark.parametrize(("k", "max_frames", "expected"), [(501, 200, 200), (30, 200, 30)])
def test_result_plays(tmp_path: Path, k: int, max_frames: int, expected: int) -> None:
    result = swinging_rod(k=k)
    write_result(tmp_path / "result.vtkhdf", result, max_frames=max_frames)
    player = Player(tmp_path / "result.vtkhdf")
    times = player.times
    assert len(times) == expected
    assert times[0] == result.t[0]
    assert times[-1] == result.t[-1]
    for step in (0, expected // 3, expected - 1):
        grid = player.at(step)
        at = int(np.argmin(np.abs(result.t - times[step])))
        moved = grid.points + grid.point_data["displacement"]
        np.testing.assert_allclose(moved, result.node_positions_G[at], atol=1e-12)
        np.testing.assert_array_equal(grid.cell_data["body_id"], np.zeros(8))


def test_result_with_tables_of_many_bodies_plays(tmp_path: Path) -> None:
    """Format 2.0."""
    result = crowd(150)
    write_result(tmp_path / "result.vtkhdf", result)
    player = Player(tmp_path / "result.vtkhdf")
    assert len(player.times) == len(result.t)
    for step in (0, len(result.t) - 1):
        grid = player.at(step)
        moved = grid.points + grid.point_data["displacement"]
        np.testing.assert_allclose(moved, result.node_positions_G[step], atol=1e-12)


def test_result_with_two_meshed_bodies_keeps_them_apart(tmp_path: Path) -> None:
    import dataclasses

    one = swinging_rod()
    rod = one.bodies[0]
    pair = dataclasses.replace(
        one,
        bodies=(rod, dataclasses.replace(rod, name="second")),
        node_positions_G=np.concatenate(
            [one.node_positions_G[:, :9], one.node_positions_G[:, :9] + [0.0, 0.0, 1.0]], axis=1
        ),
    )
    write_result(tmp_path / "result.vtkhdf", pair)
    grid = grid_of(tmp_path / "result.vtkhdf")
    second = grid.extract_cells(np.flatnonzero(grid.cell_data["body_id"] == 1))
    assert second.n_cells == 8
    np.testing.assert_array_equal(second.points[:, 2], np.ones(9))
