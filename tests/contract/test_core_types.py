"""Tests with every kernel of OpenBLAS: which types are chosen, and that their verdict counts."""

import json
import os
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

AVX2 = "fpu sse2 pni ssse3 sse4_1 sse4_2 avx fma avx2"
AVX512 = f"{AVX2} avx512f avx512dq avx512cd avx512bw avx512vl"


@pytest.fixture(scope="module")
def core_types(tools: Path) -> ModuleType:
    import core_types

    return core_types


@pytest.mark.parametrize(
    ("flags", "names"),
    [
        ("", []),
        ("fpu sse2 pni", ["Prescott"]),
        ("fpu sse2 pni sse4_2 avx", ["Prescott", "Nehalem"]),
        (AVX2, ["Prescott", "Nehalem", "Haswell", "Zen"]),
        (f"{AVX2} avx512f avx512cd", ["Prescott", "Nehalem", "Haswell", "Zen"]),
        (AVX512, ["Prescott", "Nehalem", "Haswell", "Zen", "SkylakeX"]),
    ],
)
def test_types_that_a_processor_has(
    core_types: ModuleType, tmp_path: Path, flags: str, names: list[str]
) -> None:
    file = tmp_path / "cpuinfo"
    file.write_text(f"processor\t: 0\nflags\t\t: {flags}\nbugs\t\t: spectre_v1\n")
    assert core_types.available(core_types.processor_flags(file)) == names


def test_no_flags_where_the_system_has_none(core_types: ModuleType, tmp_path: Path) -> None:
    assert core_types.processor_flags(tmp_path / "cpuinfo") == set()


def some_tests(core_types: ModuleType, folder: Path, text: str) -> Any:
    file = folder / "test_kernel.py"
    file.write_text(text)
    return core_types.Tests("some", sys.executable, "numpy", (str(file),), folder / "numbers")


def run(core_types: ModuleType, tests: Any, *types: str) -> list[Any]:
    import side_by_side

    done: list[Any] = side_by_side.run_all([core_types.job(tests, name) for name in types], 2)
    return done


def test_tests_run_with_the_type_that_is_asked_for(core_types: ModuleType, tmp_path: Path) -> None:
    text = """
import json, os, pathlib
def test_type():
    folder = pathlib.Path(os.environ["PLYMOTION_FE_NUMBERS"])
    folder.mkdir(parents=True)
    (folder / "type.json").write_text(json.dumps(os.environ["OPENBLAS_CORETYPE"]))
"""
    (result,) = run(core_types, some_tests(core_types, tmp_path, text), "Nehalem")
    assert result.code == 0, result.output
    assert json.loads((tmp_path / "numbers" / "Nehalem" / "type.json").read_text()) == "Nehalem"


def test_verdict_that_depends_on_the_type_is_a_failure(
    core_types: ModuleType, tmp_path: Path
) -> None:
    text = """
import os
def test_by_luck():
    assert os.environ["OPENBLAS_CORETYPE"] != "Nehalem"
"""
    tests = some_tests(core_types, tmp_path, text)
    results = run(core_types, tests, "Prescott", "Nehalem")
    assert [result.code for result in results] == [0, 1]
    assert "test_by_luck" in results[1].output
    choice = core_types.Choice(frozenset({"SkylakeX"}), ("Prescott", "Nehalem"))
    assert core_types.summary("some", choice, results) == (
        "some: core types Prescott, Nehalem FAILED with Nehalem; all tests ran with SkylakeX"
    )


def test_kernels_are_those_that_openblas_reports(core_types: ModuleType, tmp_path: Path) -> None:
    """The chosen types round each in a way of their own; an unknown type has no kernels."""
    tests = some_tests(core_types, tmp_path, "")
    assert core_types.kernels(tests, "NoSuchType").names == frozenset()
    found = core_types.choice(tests)
    own = core_types.kernels(tests, "")
    assert own == core_types.kernels(tests, "")  # the same bits each time
    assert found.own == own.names
    used = [core_types.kernels(tests, name).rounding for name in found.types]
    assert len({own.rounding, *used}) == 1 + len(used)
    alike = {core_types.kernels(tests, name).rounding for name in found.alike}
    assert alike <= {own.rounding, *used}
    every = core_types.available(core_types.processor_flags())
    assert {*found.types, *found.alike} <= {*every}
    assert os.environ.get("OPENBLAS_VERBOSE") is None


def test_nothing_run_is_said(core_types: ModuleType) -> None:
    none = core_types.Choice(frozenset(), ())
    assert "NO CORE TYPES" in core_types.summary("some", none, [])
    alike = core_types.Choice(frozenset({"Haswell"}), (), ("Zen",))
    assert "but Haswell; Zen give" in core_types.summary("some", alike, [])
    one = core_types.Choice(frozenset({"Haswell"}), ())
    assert "NO CORE TYPES but Haswell" in core_types.summary("some", one, [])
