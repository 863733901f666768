"""Recovery of stresses in the package: round trip, checks, optional."""

import dataclasses
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from harness.damaged_files import Change, alter, dropped, refused, replaced
from samples.package_samples import cantilever, same
from samples.recovery_samples import PLY, STEEL, STEEL_STRENGTH, plies_of, rectangle_recovery

from plymotion.solver.errors import PackageError
from plymotion.solver.package import ModalPackage, read_package, validate, write_package
from plymotion.solver.package.common.materials import YieldStrength
from plymotion.solver.package.section.stress import resultants, strengths, thinned, unit_stress

SECTION = "/modal_package/sections/bar"


def with_section(**change: Any) -> ModalPackage:
    package = cantilever()
    (bar,) = package.sections
    assert bar.recovery is not None
    changed = dataclasses.replace(bar.recovery, **change)
    return dataclasses.replace(package, sections=(dataclasses.replace(bar, recovery=changed),))


def with_stations(**change: Any) -> ModalPackage:
    package = cantilever()
    assert package.recovery is not None
    return dataclasses.replace(package, recovery=dataclasses.replace(package.recovery, **change))


def test_a_package_without_recovery_is_as_before(tmp_path: Path) -> None:
    full = cantilever()
    sections = tuple(dataclasses.replace(s, recovery=None) for s in full.sections)
    bare = dataclasses.replace(full, sections=sections, recovery=None)
    write_package(tmp_path / "a.vtkhdf", bare)
    assert same(bare, read_package(tmp_path / "a.vtkhdf"))
    assert validate(tmp_path / "a.vtkhdf") == []
    with h5py.File(tmp_path / "a.vtkhdf") as file:
        assert "recovery" not in file["modal_package"]
        assert set(file[SECTION]) == {"K", "M", "end_compliance", "ply_table"}


def test_old_package_has_no_recovery(repository: Path) -> None:
    (old,) = (repository / "tests/contract/packages").glob("format-1.0*")
    package = read_package(old)
    assert package.recovery is None
    assert [s.recovery for s in package.sections] == [None]


def test_large_recovery_is_packed_and_comes_back(tmp_path: Path) -> None:
    plies = plies_of(*[("cfrp", angle) for angle in (0.0, 45.0, -45.0, 90.0)] * 2)
    recovery = rectangle_recovery(0.06, 0.03, plies, {"cfrp": PLY}, columns=40)
    package = cantilever()
    (bar,) = package.sections
    large = dataclasses.replace(bar, recovery=thinned(recovery))
    package = dataclasses.replace(package, sections=(large,))
    path = tmp_path / "a.vtkhdf"
    write_package(path, package)
    assert same(package, read_package(path))
    with h5py.File(path) as file:
        strain = file[SECTION]["recovery/strain_M"]
        assert (strain.compression, strain.shuffle) == ("gzip", True)
        assert file[SECTION]["plies/index"].compression is None  # an index would cost more
        assert strain.id.get_storage_size() < 0.3 * strain.size * 8
    assert validate(path) == []


def test_thinning_keeps_stresses_to_a_millionth() -> None:
    exact = cantilever().sections[0].recovery
    assert exact is not None
    rounded = thinned(exact)
    assert not np.array_equal(rounded.strain_M, exact.strain_M)
    np.testing.assert_allclose(rounded.strain_M, exact.strain_M, rtol=5e-7)
    assert same(thinned(rounded), rounded)
    back = resultants(rounded, unit_stress(rounded))
    scale = np.sqrt(np.diag(cantilever().sections[0].K))
    assert np.abs((back - np.eye(6)) * scale / scale[:, None]).max() < 5e-6


def test_only_materials_with_strengths_are_listed() -> None:
    steel = {**STEEL, "strength": STEEL_STRENGTH}
    plies = plies_of(("steel", 0.0), ("cfrp", 0.0))
    recovery = rectangle_recovery(0.02, 0.02, plies, {"steel": steel, "cfrp": PLY})
    assert strengths(recovery) == {"steel": YieldStrength(355e6)}


BAD_STRENGTH = {"cfrp": {**PLY, "strength": {"Xt": 1.0}}}


@pytest.mark.parametrize(
    ("package", "message"),
    [
        (with_section(ply=np.full(12, 3)), f"{SECTION}/recovery/ply: expected rows 0 ... 2"),
        (with_section(strain_M=np.full((12, 6, 6), np.nan)), f"{SECTION}/recovery/strain_M: exp"),
        (with_section(A_BM=np.zeros((12, 3, 3))), f"{SECTION}/recovery/A_BM: expected a rotation"),
        (with_section(weights=np.zeros(12)), f"{SECTION}/recovery/weights: expected an area abo"),
        (with_section(C_M=-np.ones((3, 6, 6))), f"{SECTION}/plies/C_M[0]: expected a positive"),
        (
            with_section(materials={"gfrp": PLY}),
            f"{SECTION}/plies/material: row 0: 'cfrp' is not a m",
        ),
        (with_section(materials={"cfrp": 3}), f"{SECTION}/materials: cfrp: expected a table"),
        (with_section(materials=BAD_STRENGTH), f"{SECTION}/materials: cfrp.strength.Xc: missing"),
        (with_section(points=np.zeros((11, 2))), "points: expected shape (p, 2) = (12, 2)"),
        (with_stations(section=np.ones(17, dtype=np.int64)), "recovery/section: expected rows 0"),
        (
            with_stations(station_x=-np.arange(17.0)),
            "recovery/station_x: expected positions in asc",
        ),
        (with_stations(A_BE=2 * np.eye(3)), "recovery/A_BE: expected a rotation matrix"),
        (with_stations(resultants_E=np.zeros((17, 6, 3))), "(17, 6, 4), got (17, 6, 3)"),
        (with_stations(resultants_E=np.full((17, 6, 4), np.inf)), "resultants_E: expected finite"),
    ],
)
def test_unusable_recovery_is_not_written(
    tmp_path: Path, package: ModalPackage, message: str
) -> None:
    with pytest.raises(PackageError) as error:
        write_package(tmp_path / "a.vtkhdf", package)
    assert message in str(error.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dropped(f"{SECTION}/plies/region"), f"{SECTION}/plies/region: missing; expected text (k)"),
        (dropped(f"{SECTION}/materials"), f"{SECTION}/materials: missing"),
        (dropped("modal_package/recovery/section"), "/modal_package/recovery/section: missing"),
        (
            replaced(f"{SECTION}/recovery/strain_M", np.zeros((12, 6, 5))),
            f"{SECTION}/recovery/strain_M: expected shape (p, 6, 6) = (12, 6, 6), found (12, 6, 5)",
        ),
        (
            replaced("modal_package/recovery/resultants_E", np.zeros((16, 6, 4))),
            "expected shape (s, 6, m) = (17, 6, 4), found (16, 6, 4)",
        ),
        (replaced(f"{SECTION}/materials", "{no json"), f"{SECTION}/materials: not JSON"),
    ],
)
def test_incomplete_recovery_is_refused(tmp_path: Path, change: Change, message: str) -> None:
    path = tmp_path / "a.vtkhdf"
    write_package(path, cantilever())
    alter(path, change, seal=False)
    assert message in refused(read_package, path)
    assert any(f.level == "error" for f in validate(path))


def test_changed_stress_is_noticed_by_the_checksum(tmp_path: Path) -> None:
    path = tmp_path / "a.vtkhdf"
    write_package(path, cantilever())
    with h5py.File(path, "r+") as file:
        file[SECTION]["recovery/strain_M"][0, 0, 0] *= 2.0
    with pytest.raises(PackageError, match="content was altered"):
        read_package(path)


@pytest.mark.parametrize(
    ("package", "dataset"),
    [
        # millimetres for metres
        (
            with_section(points=1e3 * cantilever().sections[0].recovery.points),  # type: ignore[union-attr]
            f"{SECTION}/recovery/strain_M",
        ),
        # bending about the other axis
        (
            with_stations(
                resultants_E=cantilever().recovery.resultants_E[:, [0, 2, 1, 3, 5, 4]] * 3.0  # type: ignore[union-attr]
            ),
            "/modal_package/recovery/resultants_E",
        ),
    ],
)
def test_validator_doubts_what_does_not_belong_together(
    tmp_path: Path, package: ModalPackage, dataset: str
) -> None:
    path = tmp_path / "a.vtkhdf"
    write_package(path, package)
    findings = validate(path)
    assert [(f.level, f.dataset) for f in findings] == [("warning", dataset)]


def test_old_file_with_recovery_holds_what_the_sample_held(repository: Path) -> None:
    (old,) = (repository / "tests/contract/packages").glob("format-1.1*")
    found, sample = read_package(old), cantilever(n=9, m=2)
    assert found.recovery is not None
    assert sample.recovery is not None
    np.testing.assert_allclose(found.recovery.station_x, sample.recovery.station_x, rtol=1e-12)
    scale = np.abs(sample.recovery.resultants_E).max()
    gap = np.abs(found.recovery.resultants_E) - np.abs(sample.recovery.resultants_E)
    assert np.abs(gap).max() < 1e-7 * scale
    before, now = found.sections[0].recovery, sample.sections[0].recovery
    assert before is not None
    assert now is not None
    assert (before.plies, before.materials) == (now.plies, now.materials)
    np.testing.assert_allclose(before.strain_M, now.strain_M, rtol=1e-9, atol=1e-20)
