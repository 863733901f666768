"""Whatever happens to a package file, the reader answers with the truth or a PackageError."""

import dataclasses
from pathlib import Path

import pytest
from harness.damaged_files import cut_is_refused, wrong_byte_is_refused_or_harmless
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from samples.package_samples import cantilever, same

from plymotion.solver.package import read_package, write_package

SAMPLE = cantilever(n=5, m=2)


@pytest.fixture(scope="module")
def raw(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("package") / "whole.vtkhdf"
    write_package(path, SAMPLE)
    return path.read_bytes()


COMMON = {"deadline": None, "suppress_health_check": [HealthCheck.function_scoped_fixture]}


@settings(max_examples=60, **COMMON)
@given(part=st.floats(0, 1, exclude_max=True))
def test_truncated_anywhere_is_refused(raw: bytes, tmp_path: Path, part: float) -> None:
    cut_is_refused(raw, part, tmp_path / "cut.vtkhdf", read_package)


@settings(max_examples=60, **COMMON)
@given(place=st.floats(0, 1, exclude_max=True), byte=st.integers(1, 255))
def test_one_wrong_byte_is_refused_or_harmless(
    raw: bytes, tmp_path: Path, place: float, byte: int
) -> None:
    wrong_byte_is_refused_or_harmless(
        raw, place, byte, tmp_path / "flip.vtkhdf", read_package, SAMPLE
    )


@settings(max_examples=15, **COMMON)
@given(
    n=st.integers(2, 30),
    m=st.integers(1, 6),
    length=st.floats(0.1, 50.0),
    name=st.text(min_size=1, max_size=20).filter(lambda s: "\0" not in s and s.isprintable()),
)
def test_round_trip(tmp_path: Path, n: int, m: int, length: float, name: str) -> None:
    package = dataclasses.replace(cantilever(n, min(m, n - 1), length), body=name)
    write_package(tmp_path / "a.vtkhdf", package)
    assert same(package, read_package(tmp_path / "a.vtkhdf"))
