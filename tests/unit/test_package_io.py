"""The package file: round trip, no incomplete files, an error for every damaged file."""

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness.damaged_files import Change, alter, refused, replaced
from harness.second_python import copied_by_other_python
from samples.package_samples import cantilever, same

from plymotion.solver.errors import PackageError
from plymotion.solver.package import (
    ModalPackage,
    from_stations,
    read_package,
    validate,
    write_package,
)
from plymotion.solver.package.body.package_file import MODAL_PACKAGE
from plymotion.solver.package.common import object_file
from plymotion.solver.package.common.container import open_file

ROOT = Path(__file__).resolve().parents[2]
DATA = "/modal_package"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("written") / "arm.vtkhdf"
    write_package(path, cantilever())
    return path


def test_round_trip_keeps_every_field(file: Path) -> None:
    assert same(cantilever(), read_package(file))


def test_round_trip_of_a_body_without_modes_sections_or_labels(tmp_path: Path) -> None:
    full = cantilever()
    none = np.zeros((17, 3, 0))
    rigid = dataclasses.replace(
        full,
        shapes_B=np.zeros((0, 17, 6)),
        mode_kinds=(),
        mode_labels=(),
        frequencies=np.zeros(0),
        mass=np.zeros((0, 0)),
        stiffness=np.zeros((0, 0)),
        damping=np.zeros((0, 0)),
        invariants=from_stations(
            full.node_mass, full.nodes_B, none, none, full.node_inertia_B, "lumped"
        ),
        interfaces=(),
        compliance=None,
        sections=(),
        recovery=None,
        second_order=None,
    )
    write_package(tmp_path / "rigid.vtkhdf", rigid)
    assert same(rigid, read_package(tmp_path / "rigid.vtkhdf"))


def test_names_outside_ascii_and_order_of_interfaces_survive(tmp_path: Path) -> None:
    full = cantilever()
    base, tip = full.interfaces
    renamed = (dataclasses.replace(tip, name="z Spitze ü"), dataclasses.replace(base, name="a 端"))
    package = dataclasses.replace(full, body="Träger", interfaces=renamed)
    write_package(tmp_path / "b.vtkhdf", package)
    assert same(package, read_package(tmp_path / "b.vtkhdf"))


def test_same_package_gives_the_same_bytes(tmp_path: Path) -> None:
    names = [tmp_path / f"{i}.vtkhdf" for i in range(2)]
    for name in names:
        write_package(name, cantilever())
    assert names[0].read_bytes() == names[1].read_bytes()


def test_small_body_makes_a_small_file(file: Path) -> None:
    assert file.stat().st_size < 100_000


def test_every_dataset_says_unit_frame_and_meaning(file: Path) -> None:
    with h5py.File(file) as h5:
        datasets: list[h5py.Dataset] = []
        h5[DATA].visititems(
            lambda _, item: datasets.append(item) if isinstance(item, h5py.Dataset) else None
        )
        assert len(datasets) > 30
        for dataset in datasets:
            assert {"unit", "frame", "description"} <= set(dataset.attrs)


def test_two_hdf5_versions_read_each_other(file: Path) -> None:
    copy = copied_by_other_python(file, "plymotion.solver.package", "package")
    assert same(cantilever(), read_package(copy))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": np.diag([1.0, 1, 1, -1e-3])}, ["modes/mass", "positive definite"]),
        ({"mass": np.eye(4) + np.eye(4, k=1)}, ["modes/mass", "symmetric", "[0, 1]"]),
        ({"stiffness": np.eye(4) + np.eye(4, k=2)}, ["modes/stiffness", "symmetric"]),
        ({"frequencies": np.array([1, 2, np.nan, 4])}, ["modes/frequencies", "finite", "[2]"]),
        ({"frequencies": np.ones(3)}, ["modes/frequencies", "(m) = (4,)", "(3,)"]),
        ({"mode_kinds": ("fixed_norml",) * 4}, ["modes/kinds", "did you mean 'fixed_normal'"]),
        ({"reference_condition": "free"}, ["reference_condition", "clamped, chord"]),
        ({"connectivity": np.arange(1, 33)}, ["mesh/connectivity", "rows 0 ... 16"]),
        ({"connectivity": np.full(32, 0.5)}, ["mesh/connectivity", "int64"]),
        ({"offsets": np.arange(17)}, ["mesh/offsets", "32"]),
        ({"node_ids": np.zeros(17, int)}, ["mesh/node_ids", "unique"]),
        ({"node_mass": np.linspace(-1, 1, 17)}, ["nodal/mass", "row 0"]),
        ({"provenance": {"x": object()}}, ["provenance", "JSON"]),
    ],
)
def test_writer_refuses_a_wrong_package_and_leaves_the_old_file(
    file: Path, change: dict[str, object], words: list[str]
) -> None:
    before = file.read_bytes()
    with pytest.raises(PackageError) as caught:
        write_package(file, dataclasses.replace(cantilever(), **change))
    for word in [str(file), *words]:
        assert word in str(caught.value)
    assert file.read_bytes() == before
    assert list(file.parent.iterdir()) == [file], "a temporary file is left"


def test_a_provenance_too_long_for_an_attribute(tmp_path: Path) -> None:
    package = dataclasses.replace(cantilever(), provenance={"x": "y" * 70_000})
    write_package(tmp_path / "arm.vtkhdf", package)
    assert read_package(tmp_path / "arm.vtkhdf").provenance == package.provenance
    assert validate(tmp_path / "arm.vtkhdf") == []


def test_writer_refuses_a_name_that_paraview_would_not_open(tmp_path: Path) -> None:
    with pytest.raises(PackageError, match=r"\.vtkhdf"):
        write_package(tmp_path / "arm.h5", cantilever())


@pytest.mark.parametrize("name", ["", ".", "a/b"])
def test_writer_refuses_interface_names_that_hdf5_cannot_hold(tmp_path: Path, name: str) -> None:
    base, tip = cantilever().interfaces
    bad = dataclasses.replace(cantilever(), interfaces=(dataclasses.replace(base, name=name), tip))
    with pytest.raises(PackageError, match="is not a valid name"):
        write_package(tmp_path / "a.vtkhdf", bad)


def test_missing_file(tmp_path: Path) -> None:
    assert "no such file" in refused(read_package, tmp_path / "none.vtkhdf")


@pytest.mark.parametrize("kept", [0.999, 0.5, 0.01])
def test_truncated_file(file: Path, kept: float) -> None:
    raw = file.read_bytes()
    file.write_bytes(raw[: int(len(raw) * kept)])
    assert "truncated" in refused(read_package, file)


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        (b"", "an empty file"),
        (b"*HEADING\nbeam model\n", "a text file"),
        (
            b'{"body": "arm", "kind": "beam"}',
            "a JSON file; of a body in build/CASE/bodies the package",
        ),
        (b"PK\x03\x04....", "a zip archive"),
        (b"\x00\x01\x02\x03" * 9, "something else"),
    ],
)
def test_file_that_is_not_hdf5(file: Path, raw: bytes, words: str) -> None:
    file.write_bytes(raw)
    message = refused(read_package, file)
    assert "not an HDF5 file" in message
    assert words in message


@pytest.mark.parametrize(
    ("groups", "words"),
    [
        (["ENS_MAA", "INFOS_GENERALES"], "a MED file"),
        (["VTKHDF"], "a VTKHDF file without modal data"),
        (["Mesh", "Function"], "XDMF"),
        (["speed", "force"], "force, speed"),
        ([], "nothing"),
    ],
)
def test_foreign_hdf5_is_named(file: Path, groups: list[str], words: str) -> None:
    with h5py.File(file, "w") as h5:
        for group in groups:
            h5.create_group(group)
    message = refused(read_package, file)
    assert "attribute format: expected 'plymotion modal package'" in message
    assert words in message


def altered(file: Path, *changes: Change, seal: bool = True) -> str:
    alter(file, *changes, seal=seal)
    return refused(read_package, file)


def test_newer_major_version_is_refused(file: Path) -> None:
    message = altered(file, lambda h5: h5.attrs.__setitem__("format_version", [2, 0]))
    assert "written by a newer Plymotion: format 2.0, this reader knows 1.x" in message


def test_newer_minor_version_is_a_warning_only(file: Path) -> None:
    with h5py.File(file, "r+") as h5:
        h5.attrs["format_version"] = [1, 7]
        h5[DATA].create_dataset("modes/novelty", data=[1.0])
        del h5.attrs["content_sha256"]
    with pytest.warns(UserWarning, match=r"format 1\.7 is newer than 1\.6"):
        assert same(cantilever(), read_package(file))


def test_missing_dataset_names_the_nearest_one(file: Path) -> None:
    message = altered(file, lambda h5: h5.move(f"{DATA}/modes/stiffness", f"{DATA}/modes/stifness"))
    assert f"{DATA}/modes/stiffness: missing; expected float64 (m, m)" in message
    assert "did you mean 'modes/stifness'" in message


@pytest.mark.parametrize(
    ("path", "data", "words"),
    [
        ("modes/mass", np.ones(4), "expected shape (m, m) = (4, 4), found (4,)"),
        ("mesh/offsets", np.arange(16), "expected shape (c+1) = (17,), found (16,)"),
        ("mesh/node_ids", np.ones(17), "expected whole numbers (int64), found float64"),
        ("modes/mass", "heavy", "expected float64, found"),
        ("interfaces/tip/phi_B", np.ones((3, 5)), "expected shape (3, m) = (3, 4), found (3, 5)"),
        ("interfaces/tip/weights", np.ones(2), "expected shape (k) = (1,), found (2,)"),
        ("interfaces/tip", 1.0, "expected a group"),
    ],
)
def test_wrong_shape_or_type(file: Path, path: str, data: object, words: str) -> None:
    message = altered(file, replaced(f"{DATA}/{path}", data))
    assert f"{DATA}/{path}: " in message
    assert words in message


def test_altered_number_fails_the_checksum(file: Path) -> None:
    def change(h5: h5py.File) -> None:
        h5[f"{DATA}/modes/stiffness"][0, 0] *= 1 + 1e-15 * 5

    assert "content_sha256: content was altered after writing" in altered(file, change)


def test_bytes_that_the_seal_covers_are_not_compared_twice(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(object_file, "content_sha256", lambda *_, **__: "another content")
    with open_file(file, PackageError) as h5:
        assert object_file.checksum_findings(h5, MODAL_PACKAGE) == []
        assert object_file.checksum_findings(h5, MODAL_PACKAGE, whole=True) != []
    with h5py.File(file, "r+") as h5:  # takes the seal away
        h5.attrs["remark"] = 1
    with open_file(file, PackageError) as h5:
        assert object_file.checksum_findings(h5, MODAL_PACKAGE) != []


def test_altered_unit_fails_the_checksum(file: Path) -> None:
    def change(h5: h5py.File) -> None:
        h5[f"{DATA}/mesh/nodes_B"].attrs["unit"] = "mm"

    assert "content_sha256" in altered(file, change)


@pytest.mark.parametrize(
    ("path", "data", "words"),
    [
        ("modes/mass", -np.eye(4), "positive definite matrix, smallest eigenvalue is -1"),
        ("modes/damping", np.eye(4) + np.eye(4, k=3), "expected a symmetric matrix"),
        ("nodal/inertia_B", np.full((17, 3, 3), np.inf), "entry [0, 0, 0] is inf"),
        ("interfaces/tip/node_ids", [99], "no node has the identifier 99"),
        ("interfaces/tip/A_BI", -np.eye(3), "rotation matrix"),
        ("interfaces/tip/psi_B", np.full((3, 4), np.nan), "finite"),
    ],
)
def test_numbers_that_cannot_be_used_without_checksum(
    file: Path, path: str, data: object, words: str
) -> None:
    message = altered(file, replaced(f"{DATA}/{path}", data), seal=False)
    assert f"{DATA}/{path}: " in message
    assert words in message


def test_reader_gives_plain_types(file: Path) -> None:
    package: ModalPackage = read_package(file)
    assert type(package.invariants.mass) is float
    assert package.mass.dtype == np.float64
    assert package.cell_types.dtype == np.int64
    assert package.n_mode == 4
