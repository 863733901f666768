"""The antenna: two sandwich panels unfold from a free satellite and are latched."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case

from plymotion.solver.package import read_package


@pytest.fixture(scope="module")
def folder(repository, tmp_path_factory):
    return case_runs(repository, "antenna-panel", tmp_path_factory.mktemp("build"))


@pytest.fixture(scope="module")
def deployment(folder):
    return run_case(folder / "deployment.json")


def test_the_latch_holds_the_panels_and_the_wing_comes_to_rest(deployment):
    t, s, summary = deployment
    assert summary["completed"]
    assert summary["warnings"] == []
    late = t > 5.0
    np.testing.assert_allclose(s["angle"][late], 0.5 * np.pi, atol=0.005)
    amplitude = [np.ptp(s["bending"][(t > a) & (t < a + 0.5)]) for a in (2.1, 5.4)]
    assert amplitude[1] < 0.5 * amplitude[0]
    assert 0.01 < s["exposure"].max() < 0.5
    assert summary["checks"]["energy_drift_relative"] < 1e-5
    assert summary["checks"]["momentum_balance"] < 1e-10


def test_the_satellite_turns_by_what_momentum_says(repository, deployment):
    """Rigid panels without angular momentum: tilt = integral of dtilt/dangle, by quadrature."""
    package = read_package(repository / "tests/packages/antenna-panel/outer.deployment.vtkhdf")
    mass, length = package.invariants.mass, 1.0
    m = np.array([80.0, mass, mass])
    inertia = np.array([8.0, mass * length**2 / 12, mass * length**2 / 12])

    def centres(tilt: float, angle: float):
        """Centres (3, 2) in the plane x, z; directions turn about +y from x towards -z."""
        turn = tilt + np.array([0.0, angle - 0.5 * np.pi, 0.5 * np.pi - angle])
        d = np.stack([np.cos(turn), -np.sin(turn)], axis=1)
        hinge = 0.3 * d[0]
        tip = hinge + length * d[1]
        r = np.stack([np.zeros(2), hinge + 0.5 * length * d[1], tip + 0.5 * length * d[2]])
        return r - m @ r / m.sum()

    def momentum(angle: float, rates: tuple[float, float]) -> float:
        """Angular momentum about y by rates of tilt and angle."""
        h = 1e-6
        r = centres(0.0, angle)
        v = (centres(h * rates[0], angle + h * rates[1]) - r) / h
        spins = rates[0] + rates[1] * np.array([0.0, 1.0, -1.0])
        return float(inertia @ spins + m @ (r[:, 1] * v[:, 0] - r[:, 0] * v[:, 1]))

    points, weights = np.polynomial.legendre.leggauss(24)
    angles = 0.25 * np.pi * (points + 1.0)
    slopes = [-momentum(a, (0.0, 1.0)) / momentum(a, (1.0, 0.0)) for a in angles]
    tilt = 0.25 * np.pi * float(weights @ slopes)
    t, s, _ = deployment
    late = s["satellite_tilt"][t > 4.0]
    assert abs(tilt) > 0.1
    assert 0.5 * (late.min() + late.max()) == pytest.approx(tilt, rel=0.01)
