"""docs/format.md, the writer and old files agree."""

import hashlib
import re
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.package_samples import cantilever, same
from samples.panel_sample import panel, with_face_stresses

from plymotion.solver.package import ModalPackage, read_package, validate, write_package
from plymotion.solver.package.body.package_schema import (
    FORMAT,
    FORMAT_VERSION,
    MASS_FORMS,
    MODE_KINDS,
    REFERENCE_CONDITIONS,
)
from plymotion.solver.package.common.container import content_sha256, set_text

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/format.md").read_text(encoding="utf-8")
OLD_FILES = sorted((Path(__file__).parent / "packages").glob("*.vtkhdf"))
ROW = re.compile(r"^\| `([^`]+)` \| ([^|]+) \| (\w+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", re.M)


def documented() -> dict[str, tuple[str, ...]]:
    """Return path -> shape, type, unit, frame, meaning, as the manual's table gives them."""
    table = PAGE.split("## Datasets")[1].split("## The invariants")[0]
    return {row[0]: tuple(cell.strip() for cell in row[1:]) for row in ROW.findall(table)}


SIZES = {
    "arm": {"n": 17, "c": 16, "c+1": 17, "i": 32, "m": 4, "s": 17, "l": 24, "p": 12},
    "panel": {"n": 34, "c": 32, "c+1": 33, "i": 96, "m": 3, "e": 32},
    "solid": {"n": 34, "c": 32, "c+1": 33, "i": 96, "m": 3, "f": 32, "g": 1},
}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    arm = cantilever()
    write_package(tmp_path / "arm.vtkhdf", replace(arm, stiffness_error=1e-3 * arm.stiffness))
    return tmp_path / "arm.vtkhdf"


@pytest.fixture
def shell_file(tmp_path: Path) -> Path:
    package = panel()
    rates = np.ones((18, package.n_mode, package.n_mode))
    laminates = tuple(replace(each, stiffness_rates=rates) for each in package.laminates)
    write_package(tmp_path / "panel.vtkhdf", replace(package, laminates=laminates))
    return tmp_path / "panel.vtkhdf"


@pytest.fixture
def solid_file(tmp_path: Path) -> Path:
    write_package(tmp_path / "solid.vtkhdf", with_face_stresses())
    return tmp_path / "solid.vtkhdf"


def written(file: Path) -> dict[str, h5py.Dataset]:
    """Return the datasets of a file by the manual's path: <interface> for a name."""
    found = {}

    def visit(path: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            path = re.sub(r"^interfaces/[^/]+", "interfaces/<interface>", path)
            path = re.sub(r"^laminates/[^/]+", "laminates/<laminate>", path)
            found[re.sub(r"^sections/[^/]+", "sections/<section>", path)] = item

    h5py.File(file)["modal_package"].visititems(visit)
    return found


def test_every_dataset_is_documented_and_every_documented_one_is_written(
    file: Path, shell_file: Path, solid_file: Path
) -> None:
    assert set(documented()) == {*written(file), *written(shell_file), *written(solid_file)}
    assert len(documented()) > 25


@pytest.mark.parametrize("name", ["file", "shell_file", "solid_file"])
def test_documented_shape_type_unit_frame_and_meaning_are_those_of_the_file(
    name: str, request: pytest.FixtureRequest
) -> None:
    path_of_file: Path = request.getfixturevalue(name)
    body = SIZES[path_of_file.stem]
    nodes = 1 if name == "file" else 2
    for path, dataset in written(path_of_file).items():
        # k and p are sizes of one interface, one section or one laminate
        sizes = body | {"k": nodes if path.startswith("interfaces") else 1}
        if path.startswith("sections"):
            sizes |= {"k": 3, "p": 12}
        shape, kind, unit, frame, meaning = documented()[path]
        axes = [] if shape == "scalar" else shape.strip("()").split(", ")
        expected = tuple(sizes[a] if a in sizes else int(a) for a in axes)
        assert dataset.shape == expected, path
        assert kind == ("text" if dataset.dtype.kind == "S" else str(dataset.dtype)), path
        said = {key: dataset.attrs[key].decode() for key in ("unit", "frame", "description")}
        meaning = meaning.removesuffix(" (optional)")
        assert said == {"unit": unit, "frame": frame, "description": meaning}, path


@pytest.mark.parametrize("name", ["format.md", "section-file.md", "shells.md"])
def test_tables_of_the_manual_are_those_that_are_generated(name: str, tools: Path) -> None:
    from format_pages import PAGES, with_table

    assert name in PAGES
    page, known = (ROOT / "docs" / name).read_text(encoding="utf-8"), PAGES[name]
    assert f" `/{known.group}` | shape | type | unit | frame | meaning |" in page
    assert with_table(page, known.group, known.kind) == page
    assert with_table(page.replace("(optional)", ""), known.group, known.kind) == page


def test_manual_names_version_words_and_attributes(file: Path) -> None:
    assert f"format {FORMAT_VERSION[0]}.{FORMAT_VERSION[1]}" in PAGE.splitlines()[0]
    for word in (FORMAT, *MODE_KINDS, *REFERENCE_CONDITIONS, *MASS_FORMS):
        assert f"`{word}`" in PAGE, word
    with h5py.File(file) as h5:
        for name in h5.attrs:
            assert f"| `{name}` |" in PAGE, name


def test_example_of_the_manual_runs_and_validates(tmp_path: Path) -> None:
    """The code block of "Writing a package", with a sample's arrays for those of "your FE code"."""
    sample = cantilever()
    block = PAGE.split("## Writing a package")[1].split("\n## ")[0]
    code = "\n".join(line[4:] for line in block.splitlines() if line.startswith("    "))
    given = {
        "X": np.moveaxis(sample.shapes_B, 0, 2),
        "nodes": sample.nodes_B,
        "ids": sample.node_ids,
        "cells": sample.connectivity.reshape(-1, 2),
        "modal_M": sample.mass,
        "modal_K": sample.stiffness,
        "node_mass": sample.node_mass,
        "node_inertia": sample.node_inertia_B,
    }
    target = tmp_path / "arm.vtkhdf"
    exec(code.replace('"arm.vtkhdf"', repr(str(target))), given)
    package = read_package(target)
    assert validate(target) == []
    assert same(sample.shapes_B, package.shapes_B)
    assert same(sample.invariants, package.invariants)


def test_checksum_follows_the_written_rule(tmp_path: Path) -> None:
    """The items of the manual, put together by hand for a small tree; texts of three kinds."""
    with h5py.File(tmp_path / "a.h5", "w") as h5:
        group = h5.create_group("modal_package")
        group.attrs["reference_condition"] = "clamped"
        group["b/x"] = np.array([[1.5, -2.0]], dtype=np.float32)
        group["b/x"].attrs["unit"] = "m"
        group["a"] = np.array(7, dtype=np.uint8)
        set_text(group["a"], "unit", "\u00b5m")
        padded = h5py.h5t.C_S1.copy()
        padded.set_size(4)
        padded.set_strpad(h5py.h5t.STR_SPACEPAD)  # as Fortran writes it
        one = h5py.h5s.create(h5py.h5s.SCALAR)
        h5py.h5a.create(group["a"].id, b"frame", padded, one).write(np.array(b"B"))
        found = content_sha256(group, "arm", "SI")
    items: list[bytes] = [b"arm", b"SI"]
    items += [b"", b"reference_condition", b"clamped"]
    items += [
        b"a",
        b"frame",
        b"B",
        b"unit",
        "\u00b5m".encode(),
        b"",
        b"i8",
        (7).to_bytes(8, "little"),
    ]
    items += [b"b"]
    items += [b"b/x", b"unit", b"m", b"1,2", b"f8", np.array([1.5, -2.0], "<f8").tobytes()]
    data = b"".join(str(len(item)).encode() + b":" + item for item in items)
    assert found == hashlib.sha256(data).hexdigest()


@pytest.mark.parametrize("old", OLD_FILES, ids=lambda path: path.stem)
def test_old_files_are_still_read(old: Path) -> None:
    package = read_package(old)
    assert [f for f in validate(old) if f.level == "error"] == []
    assert isinstance(package, ModalPackage)
    assert package.n_mode == len(package.mode_kinds) > 0


def test_an_old_file_of_this_version_is_kept() -> None:
    version = f"format-{FORMAT_VERSION[0]}.{FORMAT_VERSION[1]}"
    assert any(path.stem.startswith(version) for path in OLD_FILES)


def test_old_file_holds_what_the_sample_held() -> None:
    """The numbers themselves: the oldest file against the body it was written from."""
    old, now = read_package(OLD_FILES[0]), cantilever(n=9, m=2)
    np.testing.assert_allclose(old.nodes_B, now.nodes_B, rtol=1e-12)
    np.testing.assert_allclose(old.stiffness, now.stiffness, rtol=1e-7)
    np.testing.assert_allclose(old.invariants.T00_B, now.invariants.T00_B, rtol=1e-12)
    assert [i.name for i in old.interfaces] == ["base", "tip"]
