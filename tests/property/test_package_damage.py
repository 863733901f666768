"""Whatever happens to a package file, the reader answers with the truth or a PackageError."""

import dataclasses
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from package_samples import cantilever, same

from plymotion.solver.errors import PackageError
from plymotion.solver.package import read_package, validate, write_package

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
    path = tmp_path / "cut.vtkhdf"
    path.write_bytes(raw[: int(part * len(raw))])
    with pytest.raises(PackageError, match=r"cut\.vtkhdf: "):
        read_package(path)
    assert [f.level for f in validate(path)] == ["error"]


@settings(max_examples=60, **COMMON)
@given(place=st.floats(0, 1, exclude_max=True), byte=st.integers(1, 255))
def test_one_wrong_byte_is_refused_or_harmless(
    raw: bytes, tmp_path: Path, place: float, byte: int
) -> None:
    """Harmless: in the gaps between objects, in provenance, or in the ParaView part."""
    path = tmp_path / "flip.vtkhdf"
    damaged = bytearray(raw)
    damaged[int(place * len(raw))] ^= byte
    path.write_bytes(damaged)
    try:
        package = read_package(path)
    except PackageError as error:
        package, message = None, str(error)
    if package is None:
        assert "flip.vtkhdf: " in message
    else:
        found = {k: v for k, v in vars(package).items() if k != "provenance"}
        assert all(same(getattr(SAMPLE, name), value) for name, value in found.items())


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
