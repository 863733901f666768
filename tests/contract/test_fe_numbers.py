"""The comparison of numbers between two versions of DOLFINx finds what differs."""

import json
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="module")
def fe_numbers(tools: Path) -> ModuleType:
    import fe_numbers

    return fe_numbers


def differences(fe_numbers: ModuleType, folder: Path, a: dict, b: dict) -> list[str]:
    """The comparison of two files written from these numbers."""
    first, second = folder / "0.5.2.json", folder / "0.11.0.json"
    first.write_text(json.dumps(a))
    second.write_text(json.dumps(b))
    return fe_numbers.differences(first, second)


BASE = {"K": [[4.0e6, 1.0e-3], [1.0e-3, 2.0]], "f": [52.66, 330.0]}


def test_rounding_is_accepted(fe_numbers: ModuleType, tmp_path: Path) -> None:
    other = {"K": [[4.0e6 * (1 + 5e-10), 0.0], [2.0e-3, 2.0]], "f": [52.66, 330.0]}
    assert differences(fe_numbers, tmp_path, BASE, other) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"K": [[4.0e6 * (1 + 2e-9), 1.0e-3], [1.0e-3, 2.0]]}, "differ by 2.00e-09"),
        ({"K": [[4.0e6, 1.0e-3]]}, "shape"),
        ({"f": [52.66, float("nan")]}, "not finite"),
        ({"g": 1.0}, "missing in"),
    ],
)
def test_differences_are_found(
    fe_numbers: ModuleType, tmp_path: Path, change: dict, message: str
) -> None:
    (line,) = differences(fe_numbers, tmp_path, BASE, {**BASE, **change})
    assert message in line


def test_nothing_recorded_is_no_agreement(fe_numbers: ModuleType, tmp_path: Path) -> None:
    assert differences(fe_numbers, tmp_path, {}, {}) != []


def test_common_names_only(fe_numbers: ModuleType, tmp_path: Path) -> None:
    first, second = tmp_path / "first.json", tmp_path / "second.json"
    first.write_text(json.dumps(BASE))
    second.write_text(json.dumps({"f": BASE["f"], "g": 1.0}))
    assert fe_numbers.differences(first, second, common=True) == []
    assert len(fe_numbers.differences(first, second)) == 2
    second.write_text(json.dumps({"g": 1.0}))
    (line,) = fe_numbers.differences(first, second, common=True)
    assert "no numbers to compare" in line
