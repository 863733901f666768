"""Every file format: what was changed is refused or read as it was; no file reads another one."""

import dataclasses
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from harness.hostile_profile import count, tries
from samples.package_samples import cantilever
from samples.result_samples import swinging_rod
from samples.section_samples import rectangle
from samples.shell_file_samples import plate
from samples.sweep_samples import FORCE, ball

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError, PackageError
from plymotion.solver.package import read_package, write_package
from plymotion.solver.package.common.container import content_sha256
from plymotion.solver.package.common.files import SEAL
from plymotion.solver.package.section.section_file import read_section, write_section
from plymotion.solver.package.shell.shell_file import read_shell, write_shell
from plymotion.solver.report.section.codes import read_results
from plymotion.solver.results import read_result, write_result
from plymotion.solver.studies.sweep.file import believed_rows, read_sweep

REFUSED = (PackageError, InputError)


@dataclass(frozen=True)
class Format:
    """A file format: a sample, and its reader."""

    write: Callable[[Path], object]
    read: Callable[[Path], Any]
    data: str  # a dataset that is read


FORMATS = {
    "package": Format(
        lambda path: write_package(path, cantilever(n=5, m=2)),
        read_package,
        "modal_package/modes/stiffness",
    ),
    "section": Format(lambda path: write_section(path, rectangle()), read_section, "section/K"),
    "shell": Format(lambda path: write_shell(path, plate()), read_shell, "shell/mesh/nodes_G"),
    "result": Format(lambda path: write_result(path, swinging_rod()), read_result, "results/q"),
    "sweep": Format(lambda path: _sweep(path), read_sweep, "signals/x/final"),
}


def _sweep(path: Path) -> None:
    file = ball(path.parent / "case", f"{FORCE} = [0.0, 1.0, 2.0]", 'histories = ["x"]')
    assert main(["sweep", str(file), "--quiet", "--no-figures"]) == 0
    shutil.copy(file.with_suffix("") / "sweep.h5", path)


@pytest.fixture(scope="module", params=FORMATS)
def kind(request, tmp_path_factory):
    """A format, and a file of it."""
    path = tmp_path_factory.mktemp(request.param) / "whole.vtkhdf"
    FORMATS[request.param].write(path)
    return FORMATS[request.param], path


def _equal(a: Any, b: Any) -> bool:
    """Compare objects exactly, NaN with NaN; provenance is not covered by the checksum."""
    if dataclasses.is_dataclass(a):
        a, b = vars(a), vars(b)
    if isinstance(a, dict):
        names = [name for name in a if name != "provenance"]
        return set(a) == set(b) and all(_equal(a[name], b[name]) for name in names)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(_equal, a, b))
    if isinstance(a, np.ndarray) and a.dtype.kind == "f":
        return np.array_equal(a, b, equal_nan=True)
    return bool(np.array_equal(a, b)) or (a != a and b != b)


def _outcome(known: Format, path: Path) -> tuple[Any, str]:
    try:
        return known.read(path), ""
    except REFUSED as error:
        return None, str(error)


def test_flips_and_truncations_are_never_silent(kind, tmp_path, monkeypatch):
    """Read equal, or refused with the name of the file."""
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path / "cache"))
    known, path = kind
    name = next(name for name, known_as in FORMATS.items() if known_as is known)
    raw, sound = path.read_bytes(), known.read(path)
    generator = np.random.default_rng(7)
    damaged = tmp_path / "damaged.vtkhdf"
    refused = 0
    for _ in range(tries(40, 200)):
        changed = bytearray(raw)
        changed[generator.integers(len(raw))] ^= 1 << int(generator.integers(8))
        damaged.write_bytes(changed)
        found, message = _outcome(known, damaged)
        right = "damaged.vtkhdf: " in message or _equal(found, sound)
        end = "refused" if message else "done"
        count(f"reading a {name} file: one bit changed", end if right else "silent change")
        assert right
        refused += bool(message)
    assert refused
    for _ in range(tries(10, 50)):
        damaged.write_bytes(raw[: generator.integers(len(raw))])
        with pytest.raises(REFUSED, match=r"damaged\.vtkhdf: "):
            known.read(damaged)
        count(f"reading a {name} file: truncated", "refused")


ODD_SHAPES: dict[str, Callable[[np.ndarray], Any]] = {
    "shorter": lambda v: v[:-1] if v.ndim else v,
    "longer": lambda v: np.concatenate([v, v]) if v.ndim else np.array([v, v]),
    "empty": lambda v: v[:0] if v.ndim else v,
    "a single one": lambda v: v.ravel()[0] if v.size else 0.0,
    "another axis": lambda v: np.stack([v, v]),
    "text": lambda v: "x",
    "whole numbers": lambda v: np.zeros(v.shape, int),
}


def test_datasets_of_another_shape_are_refused_in_words(kind, tmp_path, monkeypatch):
    """As a program of others might write them: without seal and checksum, or with a right seal."""
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path / "cache"))
    known, path = kind
    name = next(name for name, known_as in FORMATS.items() if known_as is known)
    with h5py.File(path) as file:
        found: list[str] = []
        file.visititems(lambda n, item: found.append(n) if isinstance(item, h5py.Dataset) else None)
    generator = np.random.default_rng(3)
    for _ in range(tries(12, 150)):
        copy, dataset = tmp_path / "copy.vtkhdf", found[generator.integers(len(found))]
        shutil.copy(path, copy)
        way = list(ODD_SHAPES)[generator.integers(len(ODD_SHAPES))]
        with h5py.File(copy, "r+") as file:
            values, attributes = np.asarray(file[dataset][()]), dict(file[dataset].attrs)
            del file[dataset]
            file[dataset] = ODD_SHAPES[way](values)
            file[dataset].attrs.update(attributes)
            file.attrs.pop("content_sha256", None)
        if name in ("result", "sweep"):  # not read without
            content = copy.read_bytes()
            copy.write_bytes(content + SEAL + sha256(content).hexdigest().encode() + b"\n")
        _, message = _outcome(known, copy)
        assert "copy.vtkhdf: " in message or not message
        count(
            f"reading a {name} file: a dataset of another shape", "refused" if message else "done"
        )


def _numbers(kind: tuple[Format, Path], folder: Path) -> tuple[Path, str]:
    """A copy of the file whose largest dataset is moved to another file of the same numbers."""
    known, path = kind
    copy = folder / "copy.vtkhdf"
    shutil.copy(path, copy)
    return copy, known.data


@pytest.mark.parametrize("way", ["external link", "soft link", "external storage", "virtual"])
def test_no_file_reads_another_one(kind, tmp_path, way):
    copy, name = _numbers(kind, tmp_path)
    with h5py.File(copy, "r+") as file:
        values, attributes = file[name][()], dict(file[name].attrs)
        del file[name]
        if way == "external link":
            with h5py.File(tmp_path / "other.h5", "w") as other:
                other["x"] = values
            file[name] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/x")
        elif way == "soft link":
            file["elsewhere"] = values
            file[name] = h5py.SoftLink("/elsewhere")
        elif way == "external storage":
            (tmp_path / "raw").write_bytes(np.ascontiguousarray(values).tobytes())
            storage = [(str(tmp_path / "raw"), 0, h5py.h5f.UNLIMITED)]
            file.create_dataset(name, values.shape, values.dtype, external=storage)
        else:
            with h5py.File(tmp_path / "other.h5", "w") as other:
                other["x"] = values
            layout = h5py.VirtualLayout(values.shape, values.dtype)
            layout[...] = h5py.VirtualSource(str(tmp_path / "other.h5"), "x", values.shape)
            file.create_virtual_dataset(name, layout)
        if not way.endswith("link"):
            file[name].attrs.update(attributes)
    with pytest.raises(REFUSED, match="expected data in the file itself, found ") as told:
        kind[0].read(copy)
    assert str(copy) in str(told.value)
    assert name in str(told.value)


def test_files_of_more_data_than_they_can_hold(kind, tmp_path):
    """Reading the array would fill 8 GB of memory with one value: nothing of it is written."""
    copy, name = _numbers(kind, tmp_path)
    with h5py.File(copy, "r+") as file:
        attributes = dict(file[name].attrs)
        del file[name]
        file.create_dataset(name, (10**9,), float, chunks=(1_000_000,))
        file[name].attrs.update(attributes)
    assert copy.stat().st_size < 1_000_000
    with pytest.raises(REFUSED, match=f"{name}: 8000000000 bytes, more than this file can hold"):
        kind[0].read(copy)


def test_a_circle_of_groups_ends(kind, tmp_path):
    copy, name = _numbers(kind, tmp_path)
    group = name.partition("/")[0]
    with h5py.File(copy, "r+") as file:
        file[f"{group}/again"] = file[group]
    with pytest.raises(REFUSED, match=r"copy\.vtkhdf: "):
        kind[0].read(copy)


def test_checksums_cover_data_under_every_name(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["g/one"] = [1.0, 2.0]
        before = content_sha256(file["g"])
        file["g/two"] = file["g/one"]
        with_both = content_sha256(file["g"])
        del file["g/two"]
        file["g/two"] = [1.0, 2.0]
        assert content_sha256(file["g"]) == with_both != before


def test_a_result_without_its_seal_is_refused(tmp_path):
    write_result(tmp_path / "r.vtkhdf", swinging_rod())
    with h5py.File(tmp_path / "r.vtkhdf", "r+") as file:
        assert "content_sha256" not in file.attrs  # reads all back: a third of the time to write
        file.attrs["remark"] = "HDF5 takes the seal off when it opens a file for changes"
    with pytest.raises(InputError, match="content was altered"):
        read_result(tmp_path / "r.vtkhdf")


def test_numbers_of_a_section_are_checked_before_they_are_shown(tmp_path):
    write_section(tmp_path / "s.vtkhdf", rectangle())
    with h5py.File(tmp_path / "s.vtkhdf", "r+") as file:
        file["section/K"][0, 0] *= 2.0
    with pytest.raises(PackageError, match="content was altered"):
        read_results(tmp_path / "s.vtkhdf")


def test_a_restart_believes_no_row_that_was_altered(tmp_path, capsys):
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0, 2.0]", 'histories = ["x"]')
    h5 = file.with_suffix("") / "sweep.h5"
    assert main(["sweep", str(file), "--quiet", "--no-figures"]) == 0
    sound = read_sweep(h5)
    assert len(believed_rows(h5)[0]) == 3
    for name, index in (("signals/x/final", 1), ("histories/x", (2, 3)), ("checks/drive_work", 0)):
        with h5py.File(h5, "r+") as opened:
            opened[name][index] += 1.0
        with pytest.raises(InputError, match=r"sweep\.h5: content was altered"):
            read_sweep(h5)
        known, altered = believed_rows(h5)
        assert (len(known), altered) == (2, 1)
        capsys.readouterr()
        assert main(["sweep", str(file), "--quiet", "--no-figures"]) == 0
        told = capsys.readouterr()
        assert "sweep.h5: 1 rows were altered after writing; they are computed again" in told.err
        assert "1 computed in" in told.out
        assert np.array_equal(read_sweep(h5).signal("x", "final"), sound.signal("x", "final"))
