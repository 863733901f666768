"""The actuated beam of the paper's section 4.1, from the shipped packages."""

import tomllib

import numpy as np
import pytest
import scipy.linalg
from case_samples import case_runs, run_case

from plymotion.solver.package import read_package

TIP_MASS = 5.0


@pytest.fixture(scope="module")
def reference(repository):
    file = repository / "tests/reference/dynamics/actuated_beam.toml"
    return tomllib.loads(file.read_text())["layup-1"]


@pytest.fixture(scope="module")
def runs(repository, tmp_path_factory):
    return case_runs(repository, "actuated-beam", tmp_path_factory.mktemp("build"))


@pytest.fixture(scope="module")
def layup_1(runs):
    """One run for all tests: both extremes lie before 4.6 s, the later ones are smaller."""
    return run_case(runs / "layup-1.json", t_end=4.6)


def _until(t_end, t, signals):
    return {name: values[t <= t_end] for name, values in signals.items()}


def _frequency(repository, name) -> float:
    """First frequency [Hz] of the clamped beam with its tip mass, the middle held."""
    package = read_package(repository / f"tests/packages/actuated-beam/beam.{name}.vtkhdf")
    phi = {i.name: i.phi_B for i in package.interfaces}
    M = package.mass + TIP_MASS * phi["tip"].T @ phi["tip"]
    Z = scipy.linalg.null_space(phi["mid"][1:])
    values = scipy.linalg.eigh(Z.T @ package.stiffness @ Z, Z.T @ M @ Z, eigvals_only=True)
    return float(np.sqrt(values[0]) / (2 * np.pi))


def test_first_frequency(repository, reference):
    found = _frequency(repository, "layup-1")
    assert found == pytest.approx(reference["frequency"], rel=reference["frequency_tolerance"])
    # shear deformation, and modes that lack the static shape
    assert _frequency(repository, "layup-1-shear") == pytest.approx(0.970 * found, rel=5e-3)
    assert 1.008 * found < _frequency(repository, "layup-1-four-modes") < 1.02 * found
    assert [_frequency(repository, f"layup-{k}") > 2.5 for k in (1, 2, 3)] == [True] * 3


def test_extremes_of_the_tip_deflection(layup_1, reference):
    t, s, summary = layup_1
    tip = s["tip_deflection"]
    assert summary["completed"]
    for pick, which in ((np.argmin, "min"), (np.argmax, "max")):
        k = int(pick(tip))
        assert tip[k] == pytest.approx(reference[which], rel=reference["tolerance"])
        assert t[k] == pytest.approx(reference[f"t_{which}"], abs=reference["t_tolerance"])


def test_middle_follows_the_crank(runs, layup_1):
    """Rigid kinematics of crank and link: what the beam is like does not matter there."""
    t, s, _ = run_case(runs / "layup-3.json", t_end=0.6)
    x = 0.025 * (np.cos(3.14 * t) - 1.0)
    expected = 0.025 * np.sin(3.14 * t) + 0.25 - np.sqrt(0.0625 - x**2)
    np.testing.assert_allclose(s["mid_deflection"], expected, atol=1e-6)
    # bending-twist coupling: lay-up 3 twists while it bends, lay-up 1 does not
    assert np.abs(s["tip_twist"]).max() > 1e-3
    uncoupled = _until(0.6, *layup_1[:2])
    assert np.abs(uncoupled["tip_twist"]).max() < 1e-8


def test_hinged_root_hardly_bends_statically(runs, layup_1):
    """A hinge at the root takes away what the clamp held: the deflection is all dynamics."""
    clamped = _until(0.8, *layup_1[:2])
    _, hinged, _ = run_case(runs / "layup-1-root.json", t_end=0.8)
    assert np.abs(hinged["tip_deflection"]).max() < 0.25 * np.abs(clamped["tip_deflection"]).max()
