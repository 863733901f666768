"""A solid arm from CAD between bushings: forces by hand at rest and while braking."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case
from scipy.optimize import brentq

from plymotion.solver.package import read_package

PACKAGE = "tests/packages/suspension-arm/arm.bump.vtkhdf"
ARM, GRAVITY = 0.35, 9.81  # [m] from the axis of the bushings to the ball joint, [m/s2]
STRUT, TYRE = 25e3, 200e3  # [N/m]


@pytest.fixture(scope="module")
def package(repository):
    return read_package(repository / PACKAGE)


@pytest.fixture(scope="module")
def runs(repository, tmp_path_factory):
    folder = case_runs(repository, "suspension-arm", tmp_path_factory.mktemp("build"))
    return {run: run_case(folder / f"{run}.json") for run in ("bump", "brake")}


def test_nodes_have_the_mass_of_the_body(package):
    """Corners of the cells, which carry all of the mass with its centre, inside too."""
    inv, m, x = package.invariants, package.node_mass, package.nodes_B
    assert m.sum() == pytest.approx(inv.mass, rel=1e-12)
    np.testing.assert_allclose(m @ x, inv.S0_B, atol=1e-4 * inv.mass * ARM)
    np.testing.assert_allclose(x.T @ (m[:, None] * x), inv.T00_B, atol=0.03 * inv.T00_B.max())
    drawn = np.unique(package.connectivity)
    inside = np.setdiff1d(np.arange(len(x) - 3), drawn)
    assert 0 < len(inside) < 0.1 * len(drawn)
    assert m[: len(x) - 3].min() > 0.0


def test_arm_rests_where_its_moments_vanish(package, runs):
    """Moment about the axis of the bushings of the rigid arm, turned by an angle."""
    inv = package.invariants

    def moment(angle: float) -> float:
        y, z = ARM * np.cos(angle), ARM * np.sin(angle)
        total = -GRAVITY * (35.0 * y + inv.S0_B[1] * np.cos(angle))
        anchors = ((0.25, 0.50, STRUT, 0.65), (0.35, -0.30, TYRE, 0.3175))
        for at_y, at_z, stiffness, free in anchors:
            d = np.array([y - at_y, z - at_z])
            length = np.linalg.norm(d)
            force = stiffness * (free - length) * d / length
            total += y * force[1] - z * force[0]
        return float(total)

    rest = ARM * np.sin(brentq(moment, -0.1, 0.1))
    for _, signals, summary in runs.values():
        assert summary["completed"]
        assert summary["warnings"] == []
        assert signals["wheel"][0] == pytest.approx(rest, abs=5e-5)  # the bushings give 3e-5 m


def test_bushings_take_the_couple_of_the_brakes(runs):
    """3 kN at 0.35 m from the axis: a couple of two bushings 0.3 m apart, at the end of the run."""
    rear = [runs[run][1]["rear_bush"][-1] for run in ("bump", "brake")]
    expected = 3000.0 * ARM / 0.3 / 3e6
    assert rear[0] - rear[1] == pytest.approx(expected, rel=0.03)  # strut and tyre lean by 2 mm
    lowest = [runs[run][1]["strength"].min() for run in ("bump", "brake")]
    assert 1.0 < lowest[1] < 0.7 * lowest[0]
