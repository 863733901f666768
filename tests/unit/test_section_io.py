"""The section file: round trip, ParaView, the manual, stresses."""

import dataclasses
import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.package_samples import same
from samples.section_samples import rectangle, with_recovery
from samples.vtk_samples import grid_of

from plymotion.solver.package import validate
from plymotion.solver.package.common.recovery_schema import RESULTANTS
from plymotion.solver.package.section.section_file import read_section, write_section
from plymotion.solver.package.section.stress import cell_means, resultants, unit_stress

ROOT = Path(__file__).resolve().parents[2]


PAGE = (ROOT / "docs/section-file.md").read_text(encoding="utf-8")


ROW = re.compile(r"^\| `([^`]+)` \| ([^|]+) \| (\w+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", re.M)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("written") / "bar.vtkhdf"
    write_section(path, rectangle())
    return path


@pytest.mark.parametrize("cell", ["quad9", "triangle6"])
@pytest.mark.parametrize("estimate", [True, False])
def test_round_trip_keeps_every_field(tmp_path: Path, cell: str, estimate: bool) -> None:
    section = rectangle(name="Träger 端", cell=cell, estimate=estimate)
    write_section(tmp_path / "a.vtkhdf", section)
    assert same(section, read_section(tmp_path / "a.vtkhdf"))
    assert validate(tmp_path / "a.vtkhdf") == []


def test_round_trip_without_warnings(tmp_path: Path) -> None:
    section = dataclasses.replace(rectangle(), warnings=(), provenance={})
    write_section(tmp_path / "a.vtkhdf", section)
    assert same(section, read_section(tmp_path / "a.vtkhdf"))


def test_long_description_is_kept(tmp_path: Path) -> None:
    plies = [{"material": "cfrp", "angle_deg": 30.0, "thickness": 0.000127}] * 2000
    section = dataclasses.replace(rectangle(), provenance={"spec": {"plies": plies, "name": "ü"}})
    write_section(tmp_path / "a.vtkhdf", section)
    assert read_section(tmp_path / "a.vtkhdf").provenance == section.provenance
    assert validate(tmp_path / "a.vtkhdf") == []


def test_same_section_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_section(tmp_path / f"{name}.vtkhdf", rectangle())
    assert (tmp_path / "a.vtkhdf").read_bytes() == (tmp_path / "b.vtkhdf").read_bytes()


def test_manual_has_every_dataset_with_its_shape_type_unit_frame_and_meaning(file: Path) -> None:
    table = PAGE.split("## Datasets")[1].split("## The view for ParaView")[0]
    documented = {row[0]: [cell.strip() for cell in row[1:]] for row in ROW.findall(table)}
    section = rectangle()
    sizes = {
        "n": len(section.mesh.nodes),
        "c": len(section.mesh.cell_types),
        "c+1": len(section.mesh.offsets),
        "i": len(section.mesh.connectivity),
        "p": len(section.recovery.points),
        "k": 4,
        "r": 2,
        "w": 1,
    }
    with h5py.File(file) as h5:
        written = {}
        h5["section"].visititems(
            lambda path, item: written.update(
                {path: item} if isinstance(item, h5py.Dataset) else {}
            )
        )
        assert set(documented) == set(written)
        for path, dataset in written.items():
            shape, kind, unit, frame, meaning = documented[path]
            axes = [] if shape == "scalar" else shape.strip("()").split(", ")
            assert dataset.shape == tuple(sizes[a] if a in sizes else int(a) for a in axes), path
            assert kind == ("text" if dataset.dtype.kind == "S" else str(dataset.dtype)), path
            said = [dataset.attrs[key].decode() for key in ("unit", "frame", "description")]
            assert said == [unit, frame, meaning.removesuffix(" (optional)")], path
        for name in h5.attrs:
            assert f"| `{name}` |" in PAGE, name


@pytest.mark.parametrize("cell", ["quad9", "triangle6"])
def test_paraview_opens_mesh_warping_directions_and_stresses(tmp_path: Path, cell: str) -> None:
    section = rectangle(cell=cell)
    write_section(tmp_path / "bar.vtkhdf", section)
    grid = grid_of(tmp_path / "bar.vtkhdf")
    mesh = section.mesh
    np.testing.assert_array_equal(grid.points, np.pad(mesh.nodes, ((0, 0), (1, 0))))
    np.testing.assert_array_equal(grid.cell_connectivity, mesh.connectivity)
    np.testing.assert_array_equal(grid.celltypes, mesh.cell_types)
    for i, name in enumerate(RESULTANTS):
        np.testing.assert_array_equal(grid.point_data[f"warping_{name}"], section.warping[i])
    for name in ("region", "ply", "fibre"):
        np.testing.assert_array_equal(grid.cell_data[name], getattr(mesh, name))
    np.testing.assert_array_equal(grid.cell_data["layer_direction"][:, 1:], mesh.layer_direction)
    assert set(np.unique(grid.cell_data["angle_deg"])) == {0.0, 30.0, -45.0}
    # VTK measures the curved cells: the area is that of the points of recovery
    area = grid.compute_cell_sizes()["Area"]
    found = np.bincount(section.recovery.cell, weights=section.recovery.weights)
    np.testing.assert_allclose(area, found, rtol=1e-9)


def test_stresses_for_paraview_are_cell_means_in_its_order(file: Path) -> None:
    """Bending about x2 of nu = 0: s11 = M2 x3 / I2, linear, so the mean is that of the middle."""
    section, grid = rectangle(), grid_of(file)
    middle = grid.cell_centers().points
    I2 = 0.06 * 0.02**3 / 12
    stress = grid.cell_data["stress_M2"]
    np.testing.assert_allclose(stress[:, 0], middle[:, 2] / I2, rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(stress[:, 1:], 0.0, atol=1e-6 * np.abs(stress).max())
    shear = grid.cell_data["stress_F2"]  # xx yy zz xy yz xz: 12 is the fourth
    means = cell_means(section, unit_stress(section.recovery))
    np.testing.assert_array_equal(shear[:, 3], means[:, 5, 1])
    assert np.all(shear[:, 3] > 0.0)
    np.testing.assert_allclose(shear[:, [0, 1, 2, 4, 5]], 0.0, atol=1e-9 * shear.max())


def test_view_stores_mesh_and_warping_once(file: Path) -> None:
    with h5py.File(file) as h5:
        view = h5["VTKHDF"]
        assert view["Connectivity"] == h5["section/mesh/connectivity"]
        assert view["CellData/fibre"] == h5["section/mesh/fibre"]
        assert view["Points"].is_virtual
        assert view["CellData/layer_direction"].is_virtual
        assert all(d.is_virtual for d in view["PointData"].values())


def test_unit_stresses_integrate_to_unit_resultants() -> None:
    for cell in ("quad9", "triangle6"):
        recovery = rectangle(cell=cell).recovery
        back = resultants(recovery, unit_stress(recovery))
        np.testing.assert_allclose(back, np.eye(6), atol=1e-11)


def test_stresses_of_the_sample_are_those_of_the_closed_form() -> None:
    """Turned into ply axes and back: the fibre angles must not be seen in section axes."""
    section = rectangle()
    stress = unit_stress(section.recovery)
    x2, x3 = section.recovery.points.T
    np.testing.assert_allclose(stress[:, 0, 5], -x2 / (0.02 * 0.06**3 / 12), rtol=1e-9)
    np.testing.assert_allclose(
        stress[:, 4, 2], 1.5 / 0.0012 * (1 - (x3 / 0.01) ** 2), rtol=1e-9, atol=1e-9
    )


def test_validator_warns_where_stresses_miss_their_resultant(tmp_path: Path) -> None:
    strain_M = rectangle().recovery.strain_M.copy()
    strain_M[:, :, 3] *= 1.001
    write_section(tmp_path / "a.vtkhdf", with_recovery(strain_M=strain_M))
    (finding,) = validate(tmp_path / "a.vtkhdf")
    assert finding.level == "warning"
    assert finding.dataset == "/section/recovery/strain_M"
    assert "unit M1 integrate to M1 = 1.001" in finding.message
