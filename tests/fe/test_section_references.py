"""Sections of the library against published and independent 6x6 matrices, entry by entry.

Geometry, lay-up and values are read from tests/reference/sections; meshes are those that the
library makes by default.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.section_cases import section as described

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.timoshenko import scaled

FOLDER = Path(__file__).resolve().parent.parent / "reference" / "sections"
FILES = [path for path in sorted(FOLDER.glob("[0-9]*.toml")) if path.name[:3] != "30_"]
BOXES = [path for path in FILES if path.name[:2] in ("20", "21", "22", "23")]


def read(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def test_every_reference_is_there() -> None:
    assert len(FILES) == 20
    assert len(BOXES) == 4


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_stiffness_and_mass(path: Path, record: Callable[[str, Any], None]) -> None:
    reference = read(path)
    verified = reference["verified"]
    section = analyse(described(path.name[:3]), estimate=False)
    expected = np.array(verified["K"])
    error = scaled(section.K - expected, expected)
    # the accuracy of a reference is the change in its last refinement: codes cannot agree better
    tolerance = max(verified["change_between_last_two_levels"], 1e-4)
    assert tolerance < 1e-3
    assert error.max() < tolerance, (
        f"{error.max():.1e} at {np.unravel_index(error.argmax(), (6, 6))}"
    )

    moments = verified["mass_moments"]
    diagonal = [verified["mass_per_length"]] * 3 + [moments["i11"], moments["i22"], moments["i33"]]
    assert np.diag(section.M) == pytest.approx(diagonal, rel=5e-5)
    size = np.sqrt(section.M[3, 3] / section.M[0, 0])
    assert section.M[4, 5] == pytest.approx(-moments["i23"], abs=1e-4 * section.M[3, 3])
    for name in ("shear_centre", "tension_centre"):
        centre = getattr(section, name)
        assert np.abs(centre - np.array(verified[name])).max() < 5e-4 * size
    record(f"section/{reference['id']}/K", section.K)
    record(f"section/{reference['id']}/M", section.M)


@pytest.mark.one_end
@pytest.mark.parametrize("path", BOXES, ids=lambda path: path.stem)
def test_paper_boxes_on_default_and_fine_meshes(path: Path) -> None:
    """Default mesh within 5e-4; a fine one within 1e-4 of the limit of refinement."""
    reference = read(path)
    expected = np.array(reference["verified"]["K"])
    spec = described(path.name[:3])
    default = analyse(spec, estimate=False)
    assert default.provenance["dofs"] < 7000
    assert scaled(default.K - expected, expected).max() < 5e-4
    fine = analyse(spec, accuracy=1e-4)
    assert scaled(fine.error_estimate, fine.K).max() < 1e-4
    change = reference["verified"]["change_between_last_two_levels"]
    assert scaled(fine.K - expected, expected).max() < max(1e-4, change)


@pytest.mark.one_end
def test_lay_up_2_with_30_deg_outermost() -> None:
    """Published diagonals of the box fit 0 deg outermost; the other order is another beam."""
    evidence = {"nabsa": [0.0, 30.0], "other": [30.0, 0.0]}
    pound, pound_inch_2 = 4.448222, 2.869815e-3
    units = np.array([pound, pound, pound_inch_2, pound_inch_2])
    found = {}
    for name, pair in evidence.items():
        spec = described("21")
        for region in spec["regions"].values():
            for ply, angle in zip(region["plies"], pair * 3, strict=True):
                ply["angle_deg"] = angle
        K = analyse(spec, estimate=False).K
        found[name] = np.diag(K)[[1, 2, 4, 3]] / units
    # "stacking_evidence" of the reference, from a coarser mesh: GA2, GA3 [lb], EI2, GJ [lb in2];
    # the two orders lie 1.7, 3.3, 2.2 and 2.9 % apart
    assert found["nabsa"] == pytest.approx([98146, 42423, 61403, 17708], rel=3e-3)
    assert found["other"] == pytest.approx([96484, 41050, 60041, 18230], rel=3e-3)


@pytest.mark.one_end
@pytest.mark.parametrize("path", BOXES[:3], ids=lambda path: path.stem)
def test_published_box_stiffnesses(path: Path) -> None:
    """NABSA's three digits (Popescu and Hodges 2000), diagonal and main couplings.

    Left out are the couplings below 1e3 of lay-up 3: K13 and K23, a ten-thousandth of K11, which
    the sources give 10 and 3 % larger.
    """
    reference = read(path)
    K = analyse(described(path.name[:3]), estimate=False).K
    names = ["EA", "GA2", "GA3", "GJ", "EI2", "EI3"]
    pound, inch = 4.448222, 0.0254
    unit = np.array([pound] * 3 + [pound * inch] * 3)
    checked = 0
    for name, value in reference["published"]["nabsa"].items():
        i, j = [names.index(name)] * 2 if name in names else [int(n) - 1 for n in name[1:]]
        if abs(value) < 1e3:
            continue
        checked += 1
        # magnitudes: the source has another sign frame; three digits are 0.5 %
        size = unit[i] * unit[j] / pound
        assert abs(K[i, j]) / size == pytest.approx(abs(value), rel=5e-3), name
    assert checked >= 6


def test_free_strip_is_classical_lamination() -> None:
    """The off-axis strip's compliance is that of laminate theory, an independent route."""
    reference = read(FOLDER / "15_composite_strip_30.toml")
    S = np.linalg.inv(analyse(described("15"), estimate=False).K)
    assert 1 / S[0, 0] == pytest.approx(reference["analytic"]["EA_free_strip"], rel=1e-6)
    assert 1 / S[4, 4] == pytest.approx(reference["analytic"]["EI2_free_strip"], rel=1e-6)
