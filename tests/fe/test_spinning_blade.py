"""Torsion of a spinning carbon blade, its section analysed: propeller moment and trapeze effect."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from samples.beam_samples import dense
from samples.body_specs import beam_body
from samples.section_specs import rectangle_spec
from samples.stiffening_samples import steady_spin

from plymotion.preprocess.beam.beam_body import beam_model, beam_modes, beam_package
from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.line import LineSection
from plymotion.preprocess.body import build_body
from plymotion.preprocess.section.section_analysis import analyse

FILE = Path(__file__).resolve().parent.parent / "reference/dynamics/blade_torsion.toml"
REFERENCE = tomllib.loads(FILE.read_text(encoding="utf-8"))


def blade(section: dict[str, Any]) -> dict[str, Any]:
    return beam_body(
        body="blade",
        length=REFERENCE["length"],
        elements=24,
        section=section,
        modes=[{"kind": "torsion", "count": 5}],
    )


@pytest.fixture(scope="module")
def section() -> dict[str, Any]:
    width, height = REFERENCE["width"], REFERENCE["height"]
    return rectangle_spec(width, height, REFERENCE["material"])


def test_trapeze_effect_and_propeller_moment(
    section: dict[str, Any], record: Callable[[str, Any], None]
) -> None:
    package = build_body(blade(section))
    (at_rest, _), (found, _) = (steady_spin(package, w) for w in (0.0, REFERENCE["spin"]))
    record("blade_torsion", found)
    assert at_rest[0] == pytest.approx(REFERENCE["at_rest"], rel=REFERENCE["tolerance"])
    assert found[0] == pytest.approx(REFERENCE["with_trapeze"], rel=REFERENCE["tolerance"])


@pytest.mark.one_end
def test_propeller_moment_alone(section: dict[str, Any]) -> None:
    spec = read_spec(blade(section))
    found = analyse(section, where="section", estimate=False)
    model = beam_model(spec, LineSection(found.K, found.M))
    package = build_body(blade(section))
    package = beam_package(model, beam_modes(model, dense), package.sections, {})
    values, _ = steady_spin(package, REFERENCE["spin"])
    assert values[0] == pytest.approx(REFERENCE["propeller_moment"], rel=REFERENCE["tolerance"])
