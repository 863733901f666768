"""Frequencies of rotating beams: the solver's accelerations, linearised about steady spin."""

import tomllib

import numpy as np
import pytest
from beam_samples import CLAMPED, reduced
from stiffening_samples import steady_spin

from plymotion.preprocess.beam.section_mass import SectionMass
from plymotion.solver.package import read_package

# Slender to the limit of a Bernoulli beam that cannot be stretched: EI = rhoA = L = 1.
K = np.diag([1e8, 1e8, 1e8, 1.0, 1.0, 1.0])
MASS = SectionMass(1.0, np.zeros(3), np.diag([2e-10, 1e-10, 1e-10])).matrix()
PLACES = {"root": {"at": "start"}, "tip": {"at": "end"}} | {
    name: {"at": x} for name, x in (("a", 0.1), ("b", 0.25), ("c", 0.4), ("d", 0.6))
}


@pytest.fixture(scope="module")
def table(repository):
    file = repository / "tests/reference/dynamics/rotating_beam.toml"
    return tomllib.loads(file.read_text())


@pytest.fixture(scope="module")
def blade(repository):
    return read_package(repository / "tests/packages/rotating-blade/blade.stiffened.vtkhdf")


def beam(plane: str, modes):
    return reduced(CLAMPED, modes, elements=20, K=K, mass=MASS, interfaces=PLACES).package


def near_root(plane: str, vibrations: int, places: str):
    """The lowest vibrations and the static shapes of forces where spinning bends the beam most."""
    load = "y" if plane == "xy" else "z"
    forces = [{"kind": "attachment", "at": at, "directions": [load]} for at in places]
    return beam(plane, [{"kind": f"bending-{plane}", "count": vibrations}, *forces])


def four(plane: str):
    return near_root(plane, 1, "abc")


def six(plane: str):
    return near_root(plane, 2, "abcd")


def first(package, spins, **options):
    return np.array([steady_spin(package, float(mu), **options)[0][0] for mu in spins])


def test_flap_of_four_modes(table):
    """Out of the plane of rotation: 3-D."""
    expected = table["no-hub"]
    found = first(four("xz"), expected["mu"])
    np.testing.assert_allclose(found, expected["flap_1"], rtol=table["tolerance"])


@pytest.mark.parametrize(("modes", "up_to"), [(four, 6), (six, 10)])
def test_flap_on_a_hub(table, modes, up_to):
    """What is left out above mu = 6 is the part of the shapes: six do for all speeds."""
    expected = table["hub"]
    spins = [mu for mu in expected["mu"] if mu <= up_to]
    found = first(modes("xz"), spins, hub=1.0)
    np.testing.assert_allclose(found, expected["flap_1"][: len(spins)], rtol=table["tolerance"])


def test_chord_of_four_modes(table):
    """In the plane of rotation, to mu = 6: the four shapes leave 2.3e-4 at 10, see below."""
    expected = table["no-hub"]
    spins = [mu for mu in expected["mu"] if mu <= 6]
    found = first(four("xy"), spins)
    np.testing.assert_allclose(found, expected["chord_1"][: len(spins)], rtol=table["tolerance"])


def test_three_flap_modes_and_chord_of_twelve_vibrations(table):
    """With more modes all columns, at all speeds: what is missing above is the shapes' part."""
    expected = table["no-hub"]
    flap, chord = (
        beam(plane, [{"kind": f"bending-{plane}", "count": 12}]) for plane in ("xz", "xy")
    )
    for row, mu in enumerate(expected["mu"]):
        if mu not in (0, 4, 8, 12):
            continue
        found = steady_spin(flap, float(mu))[0]
        known = [expected[f"flap_{k}"][row] for k in (1, 2, 3)]
        np.testing.assert_allclose(found[:3], known, rtol=table["tolerance"])
        found = steady_spin(chord, float(mu))[0]
        np.testing.assert_allclose(found[0], expected["chord_1"][row], rtol=table["tolerance"])


def test_linear_flap_does_not_stiffen_and_linear_chord_is_unstable():
    stiff = first(four("xz"), [0, 6], stiffening=False)
    np.testing.assert_allclose(stiff, 3.516, rtol=1e-3)
    slow, _ = steady_spin(four("xy"), 3.4, stiffening=False)
    fast, _ = steady_spin(four("xy"), 3.6, stiffening=False)
    assert len(fast) == len(slow) - 1  # one pair has become real
    assert slow[0] < 1.0


def test_composite_blade_against_measured_flap_frequencies(blade, repository):
    """A package of the preprocessor, its section analysed: Epps and Chandra (1996)."""
    file = repository / "tests/reference/dynamics/rotating_blade.toml"
    expected = tomllib.loads(file.read_text())
    for rpm, measured in zip(expected["rpm"], expected["flap_hz"], strict=True):
        values, columns = steady_spin(blade, rpm * np.pi / 30.0, hub=0.0635)
        flap = [k for k, label in enumerate(blade.mode_labels) if label.startswith("bending-xz")]
        share = np.abs(columns[flap]) ** 2
        is_flap = share.sum(axis=0) > 0.5 * (np.abs(columns) ** 2).sum(axis=0)
        found = values[is_flap][:4] / (2.0 * np.pi)
        gap = np.linalg.norm(found - measured) / np.linalg.norm(measured)
        assert gap < expected["tolerance"]
        assert np.abs(found / measured - 1.0).max() < 0.07  # of the first mode: see docs
