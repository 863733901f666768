"""Blades in spin: twisted, coupled and eccentric; stretched by the spin; with a swept tip."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from samples.segment_samples import cantilever, on_hub, run_of

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.studies.modes.place import at_of
from plymotion.solver.studies.modes.state import States
from plymotion.solver.studies.modes.state_modes import find_modes


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
        },
    )
    table = on_hub(table, known["hub"])
    return States(run_of(table, (about_line(K, *known["tension_centre"]), mass)))


def frequencies(states: States, speed: float) -> tuple[np.ndarray, tuple[str, ...]]:
    found = find_modes(states, states.at(at_of(f"spin={speed}"), None), check=False, ports=False)
    return found.modes.frequencies[found.modes.frequencies > 1e-3], found.notes


def test_four_segments(known: dict[str, Any]) -> None:
    states = blade(known, 4, [{"kind": "lowest", "count": 2}])
    rates, notes = frequencies(states, known["spin"][-1])
    np.testing.assert_allclose(rates[:5], known["frequencies"][-1], rtol=known["tolerance"])
    assert notes == ()


def test_one_body_is_less_accurate_the_more_the_spin_bends_it(known: dict[str, Any]) -> None:
    states = blade(known, 1, [{"kind": "lowest", "count": 10}, {"kind": "static-axial"}])
    for k, (tolerance, noted) in enumerate([(1e-3, False), (4e-3, False), (2.5e-2, True)]):
        rates, notes = frequencies(states, known["spin"][k])
        np.testing.assert_allclose(rates[:5], known["frequencies"][k], rtol=tolerance)
        assert any("more than 0.03 rad" in note for note in notes) == noted


@pytest.mark.parametrize("mu", [4, 10])
def test_beam_that_the_spin_stretches(published: Callable[[str], Any], mu: int) -> None:
    """Chord with the Coriolis forces of the stretch, and flap."""
    known = published("rotating_beam")["stretched"]
    stiffness = np.diag([known["EA"], 1e8, 1e8, 1.0, 1.0, 1.0])
    mass = SectionMass(1.0, np.zeros(3), 1e-10 * np.diag([2.0, 1.0, 1.0])).matrix()
    states = States(run_of(on_hub(cantilever(8, 1.0), 0.0), (stiffness, mass)))
    rates, _ = frequencies(states, mu)
    row = known["mu"].index(mu)
    exact = [known["chord_exact"][row], known["flap_exact"][row]]
    np.testing.assert_allclose(rates[:2], exact, rtol=known["exact_tolerance"])
    listed = [known["chord"][row], known["flap"][row]]
    np.testing.assert_allclose(rates[:2], listed, rtol=known["tolerance"])


@pytest.mark.parametrize("number", range(4))
def test_blade_with_a_swept_tip(published: Callable[[str], Any], number: int) -> None:
    known = published("rotating_blade")["swept"]
    inch, psi, density = 0.0254, 6894.757, 1.06869e7  # of lb s2/in4
    (w, h), E = known["section"], known["E"] * psi
    w, h, G, rho = w * inch, h * inch, E / (2.0 + 2.0 * known["nu"]), known["rho"] * density
    A, I2, I3 = w * h, w * h**3 / 12.0, h * w**3 / 12.0
    ky, kz, kt = known["factors"]
    K = np.diag([E * A, G * A / ky, G * A / kz, G * (I2 + I3) / kt, E * I2, E * I3])
    M = SectionMass(rho * A, np.zeros(3), rho * np.diag([I2 + I3, I2, I3])).matrix()
    angle = np.radians(known["sweep_deg"][number])
    c, s = float(np.cos(angle)), float(np.sin(angle))
    inner, tip = (length * inch for length in known["lengths"])
    nodes = [[float(x), 0.0, 0.0] for x in np.linspace(0.0, inner, 22)]
    nodes += [[inner + x * c, -x * s, 0.0] for x in tip * np.linspace(0.25, 1.0, 4)]
    line = {"nodes": nodes, "x2_axes": [[0.0, 1.0, 0.0]] * 21 + [[s, c, 0.0]] * 4}
    table = cantilever(5, 0.0, body={"line": line})
    del table["bodies"]["beam"]["length"], table["bodies"]["beam"]["elements"]
    states = States(run_of(on_hub(table, known["rim"] * inch), (K, M)))
    for rpm, measured in zip(known["rpm"], known["hz"], strict=True):
        rates = frequencies(states, rpm * np.pi / 30.0)[0] / (2.0 * np.pi)
        for hz in measured[number]:
            gap = np.abs(rates - hz).min()
            assert gap < max(known["tolerance"] * hz, known["floor_hz"]), (rpm, hz)
