"""A laminated plate spins up: its sag under its weight, linear and with geometric stiffening."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case

from plymotion.solver.package import read_package

SPIN = 82.0  # rad/s, root mean square of the last tenth of a second


@pytest.fixture(scope="module")
def folder(repository, tmp_path_factory):
    return case_runs(repository, "spinning-plate", tmp_path_factory.mktemp("build"))


@pytest.fixture(scope="module")
def runs(folder):
    return {name: run_case(folder / f"{name}.json") for name in ("linear", "stiffened")}


def sag(package, stiffening):
    """Static deflection of the tip under the weight at a spin [m]."""
    second = package.second_order
    K = package.stiffness - stiffening * (second.Z1_B[0, 0] + second.Z1_B[1, 1])
    middle = package.interfaces[0].position_B[1]  # the axis runs through the root's point
    K += stiffening * middle * second.Z0_B[1]
    load = -9.81 * package.invariants.S_B[2]
    tip = next(place for place in package.interfaces if place.name == "tip")
    return float(tip.phi_B[2] @ np.linalg.solve(K, load))


def test_a_linear_plate_is_warned_about(runs):
    codes = [w["code"] for w in runs["linear"][2]["warnings"]]
    assert codes == ["stiffening-matters"]
    assert runs["stiffened"][2]["warnings"] == []


def test_the_spin_holds_the_plate_straight(repository, runs):
    package = read_package(repository / "tests/packages/spinning-plate/plate.linear.vtkhdf")
    still, spinning = sag(package, 0.0), sag(package, SPIN**2)
    assert spinning / still < 0.35
    for name, expected in (("linear", still), ("stiffened", spinning)):
        t, s, summary = runs[name]
        assert summary["completed"]
        late = s["tip_z"][t > 0.4].mean()
        assert late == pytest.approx(expected, rel=0.25)
    assert 0.0 < runs["stiffened"][1]["reserve"].max() < 0.1
