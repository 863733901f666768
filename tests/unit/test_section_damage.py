"""The section file: an error for every damaged or wrong file; files of other versions."""

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness.damaged_files import (
    Change,
    alter,
    cut_is_refused,
    refused,
    replaced,
    wrong_byte_is_refused_or_harmless,
)
from harness.second_python import copied_by_other_python
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from samples.package_samples import cantilever, same
from samples.section_samples import rectangle, with_recovery
from samples.vtk_samples import grid_of

from plymotion.solver.errors import PackageError
from plymotion.solver.package import read_package, validate, write_package
from plymotion.solver.package.common.recovery_schema import Ply
from plymotion.solver.package.section.section_file import read_section, write_section
from plymotion.solver.package.section.section_schema import SECTION_FORMAT_VERSION, SectionFile

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("written") / "bar.vtkhdf"
    write_section(path, rectangle())
    return path


def with_mesh(**changes: object) -> SectionFile:
    section = rectangle()
    return dataclasses.replace(section, mesh=dataclasses.replace(section.mesh, **changes))


PLIES = rectangle().recovery.plies


@pytest.mark.parametrize(
    ("section", "words"),
    [
        (dataclasses.replace(rectangle(), K=np.eye(5)), ["/section/K", "(6, 6)", "(5, 5)"]),
        (dataclasses.replace(rectangle(), K=-np.eye(6)), ["/section/K", "above 0", "[0, 0] is -1"]),
        (
            dataclasses.replace(rectangle(), K=np.eye(6) + 2 * np.eye(6)[::-1]),
            ["/section/K", "positive definite"],
        ),
        (
            dataclasses.replace(rectangle(), M=np.eye(6) + np.eye(6, k=1)),
            ["/section/M", "symmetric", "[0, 1]"],
        ),
        (
            dataclasses.replace(rectangle(), error_estimate=-np.eye(6)),
            ["/section/error_estimate", ">= 0"],
        ),
        (
            dataclasses.replace(rectangle(), warping=np.full((6, 117, 3), np.nan)),
            ["/section/warping", "finite", "[0, 0, 0]"],
        ),
        (
            dataclasses.replace(rectangle(), warping=np.zeros((6, 116, 3))),
            ["/section/warping", "(6, n, 3) = (6, 117, 3)"],
        ),
        (dataclasses.replace(rectangle(), provenance={"x": object()}), ["provenance", "JSON"]),
        (with_mesh(ply=np.full(24, 4)), ["/section/mesh/ply", "rows 0 ... 3", "4 ... 4"]),
        (with_mesh(region=np.full(24, -1)), ["/section/mesh/region", "rows 0 ... 1"]),
        (with_mesh(regions=("a", "a")), ["/section/mesh/regions", "unique"]),
        (with_mesh(cell_types=np.full(24, 70)), ["/section/mesh/cell_types", "cell 0 is 70", "28"]),
        (with_mesh(cell_types=np.full(24, 23)), ["cell 0 has 9 nodes, its type 23 has 8"]),
        (with_mesh(connectivity=np.arange(1, 217)), ["/section/mesh/connectivity", "0 ... 116"]),
        (with_mesh(fibre=np.ones((24, 3))), ["/section/mesh/fibre", "unit vectors", "1.73"]),
        (with_mesh(layer_direction=np.zeros((24, 2))), ["/section/mesh/layer_direction"]),
        (
            with_recovery(plies=(Ply("uper", 0, "alloy", 0.0), *PLIES[1:])),
            ["/section/plies/region", "row 0", "did you mean 'upper'"],
        ),
        (
            with_recovery(plies=(*PLIES[:3], Ply("lower", 1, "aloy", 0.0))),
            ["/section/plies/material", "row 3", "did you mean 'alloy'"],
        ),
        (
            with_recovery(plies=(Ply("upper", -1, "alloy", 0.0), *PLIES[1:])),
            ["/section/plies/index", "row 0 is -1"],
        ),
        (with_recovery(materials={"alloy": {"E": {1}}}), ["/section/materials", "JSON"]),
        (with_recovery(C_M=np.zeros((4, 6, 6))), ["/section/plies/C_M[0]", "positive definite"]),
        (with_recovery(ply=np.full(216, 9)), ["/section/recovery/ply", "rows 0 ... 3"]),
        (with_recovery(cell=np.zeros(216, int)), ["/section/recovery/weights", "cell 1 is 0"]),
        (with_recovery(A_BM=2 * rectangle().recovery.A_BM), ["A_BM", "rotation", "row 0"]),
    ],
)
def test_writer_refuses_a_wrong_section_and_leaves_the_old_file(
    file: Path, section: SectionFile, words: list[str]
) -> None:
    before = file.read_bytes()
    with pytest.raises(PackageError) as caught:
        write_section(file, section)
    for word in [str(file), *words]:
        assert word in str(caught.value)
    assert file.read_bytes() == before
    assert list(file.parent.iterdir()) == [file], "a temporary file is left"


def test_writer_refuses_a_name_that_paraview_would_not_open(tmp_path: Path) -> None:
    with pytest.raises(PackageError, match=r"\.vtkhdf"):
        write_section(tmp_path / "bar.h5", rectangle())


def altered(file: Path, *changes: Change, seal: bool = True) -> str:
    alter(file, *changes, seal=seal)
    return refused(read_section, file)


def test_packages_and_sections_are_told_apart(file: Path, tmp_path: Path) -> None:
    write_package(tmp_path / "arm.vtkhdf", cantilever())
    message = refused(read_section, tmp_path / "arm.vtkhdf")
    assert "expected 'plymotion section', this is 'plymotion modal package'" in message
    with pytest.raises(PackageError, match="expected 'plymotion modal package', this is"):
        read_package(file)


def test_newer_versions(file: Path) -> None:
    message = altered(file, lambda h5: h5.attrs.__setitem__("format_version", [2, 0]))
    assert "written by a newer Plymotion: format 2.0, this reader knows 1.x" in message
    with h5py.File(file, "r+") as h5:
        h5.attrs["format_version"] = [1, 3]
        h5["section"].create_dataset("novelty", data=[1.0])
        del h5.attrs["content_sha256"]
    with pytest.warns(UserWarning, match=r"format 1\.3 is newer than 1\.2"):
        assert same(rectangle(), read_section(file))


def test_missing_and_renamed_datasets_are_named(file: Path) -> None:
    message = altered(file, lambda h5: h5.move("section/plies/C_M", "section/plies/C_m"))
    assert "/section/plies/C_M: missing; expected float64 (k, 6, 6)" in message
    assert "did you mean 'plies/C_m'" in message


@pytest.mark.parametrize(
    ("path", "data", "words"),
    [
        ("K", np.ones(6), "expected shape (6, 6) = (6, 6), found (6,)"),
        ("mesh/offsets", np.arange(24), "expected shape (c+1) = (25,), found (24,)"),
        ("mesh/ply", np.ones(24), "expected whole numbers (int64), found float64"),
        ("materials", 1.0, "expected text, found float64"),
        ("recovery/weights", "heavy", "expected float64, found"),
        ("recovery/strain_M", np.ones((216, 6, 5)), "expected shape (p, 6, 6) = (216, 6, 6)"),
        ("warnings/messages", np.array([b"a", b"b"]), "expected shape (w) = (1,), found (2,)"),
    ],
)
def test_wrong_shape_or_type(file: Path, path: str, data: object, words: str) -> None:
    message = altered(file, replaced(f"section/{path}", data))
    assert f"/section/{path}: " in message
    assert words in message


def test_altered_number_fails_the_checksum(file: Path) -> None:
    def change(h5: h5py.File) -> None:
        h5["section/recovery/strain_M"][7, 2, 1] += 1e-20

    assert "content_sha256: content was altered after writing" in altered(file, change)


def test_materials_that_are_no_json(file: Path) -> None:
    message = altered(file, replaced("section/materials", np.bytes_(b"{alloy")), seal=False)
    assert "/section/materials: not JSON" in message


def test_a_view_that_shows_another_mesh_is_an_error(file: Path) -> None:
    with h5py.File(file, "r+") as h5:
        points = 2 * h5["VTKHDF/Points"][()]
        del h5["VTKHDF/Points"]
        h5["VTKHDF/Points"] = points
    (finding,) = validate(file)
    assert (finding.level, finding.dataset) == ("error", "/VTKHDF/Points")


def test_two_hdf5_versions_read_each_other(file: Path) -> None:
    copy = copied_by_other_python(file, "plymotion.solver.package.section.section_file", "section")
    assert same(rectangle(), read_section(copy))
    assert grid_of(copy).n_cells == 24


OLD_FILES = sorted((ROOT / "tests" / "contract" / "sections").glob("*.vtkhdf"))


@pytest.mark.parametrize("old", OLD_FILES, ids=lambda path: path.stem)
def test_old_files_are_still_read(old: Path) -> None:
    """The numbers themselves: a kept file against the section it was written from."""
    assert [f for f in validate(old) if f.level == "error"] == []
    section, now = read_section(old), rectangle(name="kept bar", cells=(1, 2))
    assert (section.name, section.recovery.plies) == (now.name, now.recovery.plies)
    np.testing.assert_allclose(section.K, now.K, rtol=1e-12)
    largest = np.abs(now.recovery.strain_M).max()
    np.testing.assert_allclose(
        section.recovery.strain_M, now.recovery.strain_M, atol=1e-10 * largest
    )


def test_an_old_file_of_this_version_is_kept() -> None:
    version = ".".join(map(str, SECTION_FORMAT_VERSION))
    assert any(path.stem.startswith(f"format-{version}") for path in OLD_FILES)


SMALL = rectangle(cells=(1, 2))


COMMON = {"deadline": None, "suppress_health_check": [HealthCheck.function_scoped_fixture]}


@pytest.fixture(scope="module")
def raw(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("section") / "whole.vtkhdf"
    write_section(path, SMALL)
    return path.read_bytes()


@settings(max_examples=40, **COMMON)
@given(part=st.floats(0, 1, exclude_max=True))
def test_truncated_anywhere_is_refused(raw: bytes, tmp_path: Path, part: float) -> None:
    cut_is_refused(raw, part, tmp_path / "cut.vtkhdf", read_section)


@settings(max_examples=60, **COMMON)
@given(place=st.floats(0, 1, exclude_max=True), byte=st.integers(1, 255))
def test_one_wrong_byte_is_refused_or_harmless(
    raw: bytes, tmp_path: Path, place: float, byte: int
) -> None:
    wrong_byte_is_refused_or_harmless(
        raw, place, byte, tmp_path / "flip.vtkhdf", read_section, SMALL
    )
