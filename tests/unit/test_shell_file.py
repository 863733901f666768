"""Shell results files: round trip, reading by ParaView, error messages for damaged files."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from peers.ply_stresses import shell_file_ply_stress
from samples.shell_file_samples import plate

from plymotion.solver.errors import PackageError
from plymotion.solver.package.common.dataset import field_values, layout
from plymotion.solver.package.shell.shell_file import read_shell, write_shell
from plymotion.solver.package.shell.shell_schema import ShellFile
from plymotion.solver.report.shell.shell_text import shell_text


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("written") / "plate.vtkhdf"
    write_shell(path, plate())
    return path


def same(a: Any, b: Any) -> bool:
    return np.array_equal(a, b) if isinstance(a, np.ndarray | int) else list(a) == list(b)


def test_round_trip(file: Path) -> None:
    shell, found = plate(), read_shell(file)
    kept, back = field_values(shell), field_values(found)
    assert set(kept) == set(back)
    assert all(same(kept[path], back[path]) for path in kept)
    assert found.warnings == shell.warnings
    assert found.name == shell.name
    assert [one.plies for one in found.laminates] == [one.plies for one in shell.laminates]
    with h5py.File(file) as raw:
        for spec in layout(ShellFile):
            dataset = raw["shell"][spec.path]
            assert dataset.attrs["unit"].decode() == spec.unit
            assert dataset.attrs["description"]


def test_without_errors_by_the_mesh(tmp_path: Path) -> None:
    """As of files of format 1.1."""
    shell = plate()
    assert shell.modes is not None
    assert shell.buckling is not None
    modes = dataclasses.replace(shell.modes, error=None)
    buckling = dataclasses.replace(shell.buckling, error=None)
    cases = dataclasses.replace(shell.cases, error=None)
    shell = dataclasses.replace(shell, cases=cases, modes=modes, buckling=buckling)
    write_shell(tmp_path / "a.vtkhdf", shell)
    found = read_shell(tmp_path / "a.vtkhdf")
    assert found.cases.error is None
    assert found.modes is not None
    assert found.buckling is not None
    assert found.modes.error is None
    assert found.buckling.error is None
    assert "not estimated" in shell_text(found)


def test_without_load_cases_or_modes(tmp_path: Path) -> None:
    shell = dataclasses.replace(plate(), modes=None, buckling=None)
    write_shell(tmp_path / "a.vtkhdf", shell)
    assert read_shell(tmp_path / "a.vtkhdf").modes is None
    cases = dataclasses.replace(
        shell.cases,
        **{
            field.name: getattr(shell.cases, field.name)[:0]
            for field in dataclasses.fields(shell.cases)
        },
    )
    probes = dataclasses.replace(shell.probes, values=shell.probes.values[:0])
    write_shell(tmp_path / "b.vtkhdf", dataclasses.replace(shell, cases=cases, probes=probes))
    assert read_shell(tmp_path / "b.vtkhdf").cases.names == ()


def test_paraview_sees_displacements(file: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    shell, grid = plate(), pyvista.read(file)
    name = shell.cases.names[0]
    assert grid.n_cells == len(shell.mesh.cells)
    assert np.array_equal(grid.points, shell.mesh.nodes_G)
    shown = grid.point_data[f"{name}_displacement"]
    assert np.array_equal(shown, shell.cases.displacements_G[0, :, :3])
    assert np.array_equal(grid.cell_data[f"{name}_M"], shell.cases.resultants_E[0, :, 3:6])
    assert np.array_equal(grid.cell_data["e1"], shell.mesh.A_GE[:, :, 0])


def test_ply_stress_is_the_operator_on_resultants() -> None:
    shell = plate()
    by_region = shell_file_ply_stress(shell, shell.cases.resultants_E)
    assert len(by_region) == len(shell.mesh.regions)
    for row, stress in enumerate(by_region):
        laminate = shell.laminates[shell.mesh.laminate[row]]
        cells = np.flatnonzero(shell.mesh.region == row)
        assert stress.shape == (len(shell.cases.names), len(cells), len(laminate.plies), 3, 6)
        expected = laminate.stress_M[-1, 2] @ shell.cases.resultants_E[0, cells[-1]]
        assert stress[0, -1, -1, 2] == pytest.approx(expected, rel=1e-12)
        # through the thickness they are the normal forces again
        thickness = np.array([ply.top - ply.bottom for ply in laminate.plies])
        angle = np.radians([ply.angle_deg for ply in laminate.plies])
        along = stress[..., 1, 0] * np.cos(angle) ** 2 + stress[..., 1, 1] * np.sin(angle) ** 2
        along -= 2.0 * np.sin(angle) * np.cos(angle) * stress[..., 1, 5]
        total = along @ thickness
        N11 = shell.cases.resultants_E[:, cells, 0]
        assert total == pytest.approx(N11, rel=1e-9, abs=1e-9 * np.abs(N11).max())


def moved_node(shell: ShellFile) -> ShellFile:
    mesh = dataclasses.replace(shell.mesh, cells=shell.mesh.cells + 1)
    return dataclasses.replace(shell, mesh=mesh)


def turned(shell: ShellFile) -> ShellFile:
    mesh = dataclasses.replace(shell.mesh, A_GE=2.0 * shell.mesh.A_GE)
    return dataclasses.replace(shell, mesh=mesh)


def unknown(shell: ShellFile) -> ShellFile:
    names = ("w", *shell.probes.quantities[1:])
    return dataclasses.replace(shell, probes=dataclasses.replace(shell.probes, quantities=names))


def not_a_number(shell: ShellFile) -> ShellFile:
    energy = np.full_like(shell.cases.energy, np.nan)
    return dataclasses.replace(shell, cases=dataclasses.replace(shell.cases, energy=energy))


def short(shell: ShellFile) -> ShellFile:
    u = shell.cases.displacements_G[:, :-1]
    return dataclasses.replace(shell, cases=dataclasses.replace(shell.cases, displacements_G=u))


@pytest.mark.parametrize(
    ("spoiled", "message"),
    [
        (moved_node, "mesh/connectivity: expected rows 0"),
        (turned, "mesh/A_GE: expected a rotation"),
        (unknown, "probes/quantities: expected one of ux"),
        (not_a_number, "cases/energy: expected finite numbers"),
        (short, r"cases/displacements_G: expected shape \(l, n, 6\)"),
    ],
)
def test_what_is_inconsistent_is_not_written(
    tmp_path: Path, spoiled: Callable[[ShellFile], ShellFile], message: str
) -> None:
    with pytest.raises(PackageError, match=message):
        write_shell(tmp_path / "plate.vtkhdf", spoiled(plate()))
    assert list(tmp_path.iterdir()) == []


def test_other_names_and_damage(file: Path) -> None:
    with pytest.raises(PackageError, match=r"ending \.vtkhdf"):
        write_shell(file.with_suffix(".h5"), plate())
    with h5py.File(file, "r+") as raw:
        raw["shell/cases/energy"][0] += 1.0
    with pytest.raises(PackageError, match="altered after writing"):
        read_shell(file)
    with h5py.File(file, "r+") as raw:
        del raw["shell/cases/energy"]
    with pytest.raises(PackageError, match="cases/energy: missing"):
        read_shell(file)
    file.write_bytes(file.read_bytes()[:2000])
    with pytest.raises(PackageError, match=r"truncated|damaged"):
        read_shell(file)
