"""The 30 deg off-axis cantilever: real section analysis, real SLEPc.

Its reference frequencies are those of Euler-Bernoulli bending. The full 6x6 of
the strip adds shear flexibility (a third of G A, because bending that varies
along the strip twists it) and twist inertia: at this length they lower the second
and third frequency by 1.1 % and 2.6 %, beyond the tolerance of the reference.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.beam_samples import straight_line
from samples.body_specs import beam_body
from samples.section_specs import rectangle_spec

from plymotion.preprocess.body import build_body
from plymotion.preprocess.fenicsx import eigenpairs

FILE = Path(__file__).resolve().parent.parent / "reference/beams/strip_30_cantilever.toml"
REFERENCE = tomllib.loads(FILE.read_text(encoding="utf-8"))
HZ = np.array(REFERENCE["frequencies_hz"])


def strip(length_factor: float = 1.0) -> dict[str, Any]:
    geometry = REFERENCE["geometry"]
    return beam_body(
        body="strip",
        length=length_factor * geometry["length"],
        elements=32,
        section=rectangle_spec(
            geometry["width"], geometry["height"], REFERENCE["material"], **REFERENCE["layup"]
        ),
        modes=[{"kind": "bending-xz", "count": 3}, {"kind": "torsion", "count": 1}],
    )


def flatwise_hz(spec: dict[str, Any]) -> Any:
    package = build_body(spec)
    flatwise = [label.startswith("bending-xz") for label in package.mode_labels]
    return package.frequencies[flatwise] / (2 * np.pi)


def test_first_frequency(record: Callable[[str, Any], None]) -> None:
    found = flatwise_hz(strip())
    record("strip_30_cantilever_hz", found)
    assert found[0] == pytest.approx(HZ[0], rel=REFERENCE["tolerance"])


def test_classical_theory_has_all_reference_frequencies() -> None:
    found = flatwise_hz({**strip(), "theory": "classical"})
    assert found == pytest.approx(HZ, rel=REFERENCE["tolerance"])


@pytest.mark.xfail(
    strict=True,
    reason="the reference is Euler-Bernoulli: shear and twist inertia of the Timoshenko beam "
    "lower these by 1.1 % and 2.6 %",
)
@pytest.mark.parametrize("mode", [1, 2])
def test_higher_frequencies(mode: int) -> None:
    assert flatwise_hz(strip())[mode] == pytest.approx(HZ[mode], rel=REFERENCE["tolerance"])


def test_slender_strip_has_all_reference_frequencies() -> None:
    # ten times the length: shear, rotary and twist inertia matter a hundred times less
    found = 100.0 * flatwise_hz(strip(10.0))
    assert found == pytest.approx(HZ, rel=REFERENCE["tolerance"])
    assert found == pytest.approx(HZ, rel=5e-4)


def test_reference_is_the_shear_rigid_limit_of_the_same_beam() -> None:
    package = build_body(strip())
    section = package.sections[0]
    compliance, mass = np.linalg.inv(section.K), section.M.copy()
    compliance[2, :] *= 1e-2
    compliance[:, 2] *= 1e-2
    mass[3:, 3:] *= 1e-4
    line = straight_line(package.nodes_B[:, 0], np.linalg.inv(compliance), mass, np.eye(3))
    free = np.arange(6, 6 * line.n_node)
    K, M = line.stiffness()[free][:, free], line.mass_matrix("consistent")[free][:, free]
    values, X = eigenpairs(K, M, 5)
    flatwise = np.einsum("ki,ki->i", X[2::6], X[2::6]) > np.einsum("ki,ki->i", X[1::6], X[1::6])
    found = np.sqrt(values[flatwise][:3]) / (2 * np.pi)
    assert found == pytest.approx(HZ, rel=1e-4)
