"""Frequencies of a twisted, coupled, eccentric blade in spin against another discretisation."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from samples.segment_samples import cantilever, run_of

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.studies.modes.found import find_modes
from plymotion.solver.studies.modes.place import at_of
from plymotion.solver.studies.modes.state import States


@pytest.fixture(scope="module")
def known(published: Callable[[str], Any]) -> dict[str, Any]:
    return published("coupled_blade")


def about_line(K: np.ndarray, y: float, z: float) -> np.ndarray:
    """A stiffness about (y, z) moved to the reference line."""
    T = np.eye(6)
    T[0, 4:], T[1, 3], T[2, 3] = (z, -y), -z, y
    moved: np.ndarray = T.T @ K @ T
    return moved


def blade(known: dict[str, Any], segments: int, modes: list[dict[str, Any]]) -> States:
    K = np.diag(known["stiffness"])
    K[3, 4] = K[4, 3] = known["bend_twist"]
    m, (r_2, r_3) = known["mass"], known["radii"]
    inertia = m * np.diag([r_2**2 + r_3**2, r_2**2, r_3**2])
    mass = SectionMass(m, np.array([0.0, *known["mass_centre"]]), inertia).matrix()
    table = cantilever(
        segments,
        known["length"],
        body={
            "modes": modes,
            "elements": 32,
            "twist_deg": [[0.0, known["twist_deg"]], [1.0, 0.0]],
            "position": [known["hub"], 0.0, 0.0],
        },
    )
    table["ground"]["wall"]["position"] = [known["hub"], 0.0, 0.0]
    table["joints"]["clamp"] = {
        "kind": "revolute",
        "between": ["ground.axis", "hub.axis"],
        "drive": {"speed": 1.0},
    }
    table["joints"]["root"] = {"kind": "fixed", "between": ["hub.rim", "beam.root"]}
    table["ground"] = {"axis": {"position": [0.0, 0.0, 0.0]}}
    table["bodies"]["hub"] = {
        "kind": "rigid",
        "mass": 1.0,
        "inertia": np.eye(3).tolist(),
        "interfaces": {
            "axis": {"position": [0.0, 0.0, 0.0]},
            "rim": {"position": [known["hub"], 0.0, 0.0]},
        },
    }
    return States(run_of(table, (about_line(K, *known["tension_centre"]), mass)))


def frequencies(states: States, speed: float) -> tuple[np.ndarray, tuple[str, ...]]:
    found = find_modes(states, states.at(at_of(f"spin={speed}"), None), check=False, ports=False)
    return found.modes.frequencies[found.modes.frequencies > 1e-3][:5], found.notes


def test_four_segments(known: dict[str, Any]) -> None:
    states = blade(known, 4, [{"kind": "lowest", "count": 2}])
    rates, notes = frequencies(states, known["spin"][-1])
    np.testing.assert_allclose(rates, known["frequencies"][-1], rtol=known["tolerance"])
    assert notes == ()


def test_one_body_is_less_accurate_the_more_the_spin_bends_it(known: dict[str, Any]) -> None:
    states = blade(known, 1, [{"kind": "lowest", "count": 10}, {"kind": "static-axial"}])
    for k, (tolerance, noted) in enumerate([(1e-3, False), (4e-3, False), (2.5e-2, True)]):
        rates, notes = frequencies(states, known["spin"][k])
        np.testing.assert_allclose(rates, known["frequencies"][k], rtol=tolerance)
        assert any("more than 0.03 rad" in note for note in notes) == noted
