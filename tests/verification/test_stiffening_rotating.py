"""Frequencies of rotating beams: the solver's accelerations, linearised about steady spin."""

import tomllib

import numpy as np
import pytest
from beam_samples import CHORD, CLAMPED, reduced
from stiffening_samples import steady_spin

from plymotion.preprocess.beam.section_mass import SectionMass
from plymotion.solver.package import read_package

# Slender to the limit of a Bernoulli beam that cannot be stretched: EI = rhoA = L = 1.
K = np.diag([1e8, 1e8, 1e8, 1.0, 1.0, 1.0])
MASS = SectionMass(1.0, np.zeros(3), np.diag([2e-10, 1e-10, 1e-10])).matrix()


@pytest.fixture(scope="module")
def table(repository):
    file = repository / "tests/reference/dynamics/rotating_beam.toml"
    return tomllib.loads(file.read_text())


@pytest.fixture(scope="module")
def blade(repository):
    return read_package(repository / "tests/packages/rotating-blade/blade.stiffened.vtkhdf")


def beam(modes):
    return reduced(CLAMPED, modes, elements=20, K=K, mass=MASS).package


def four(plane: str):
    """Four static shapes of a spinning beam, good for all speeds."""
    return beam([{"kind": f"spinning-{plane}", "count": 4}])


def first(package, spins, **options):
    return np.array([steady_spin(package, float(mu), **options)[0][0] for mu in spins])


def test_flap_of_four_modes(table):
    """Out of the plane of rotation: 3-D."""
    expected = table["no-hub"]
    found = first(four("xz"), expected["mu"])
    np.testing.assert_allclose(found, expected["flap_1"], rtol=table["tolerance"])


def test_flap_on_a_hub(table):
    expected = table["hub"]
    found = first(four("xz"), expected["mu"], hub=1.0)
    np.testing.assert_allclose(found, expected["flap_1"], rtol=table["tolerance"])


def test_chord_of_four_modes(table):
    """In the plane of rotation."""
    expected = table["no-hub"]
    found = first(four("xy"), expected["mu"])
    np.testing.assert_allclose(found, expected["chord_1"], rtol=table["tolerance"])


def test_spinning_shapes_in_a_chord_frame():
    """They are static shapes like others, in both planes."""
    modes = [{"kind": f"spinning-{plane}", "count": 3} for plane in ("xy", "xz")]
    package = reduced(CHORD, modes, elements=10, K=K, mass=MASS).package
    expected = {f"spinning-{plane} {k}" for plane in ("xy", "xz") for k in (1, 2, 3)}
    assert set(package.mode_labels) == expected
    assert set(package.mode_kinds) == {"attachment"}


def test_three_flap_modes_of_twelve_vibrations(table):
    """Vibrations at rest follow the layer at the root slowly."""
    expected = table["no-hub"]
    flap = beam([{"kind": "bending-xz", "count": 12}])
    for row, mu in enumerate(expected["mu"]):
        if mu not in (0, 4, 8, 12):
            continue
        found = steady_spin(flap, float(mu))[0]
        known = [expected[f"flap_{k}"][row] for k in (1, 2, 3)]
        np.testing.assert_allclose(found[:3], known, rtol=table["tolerance"])


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
