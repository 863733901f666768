"""The robot arm of the repository: the rigid one in closed form, the flexible one by statics."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case

from plymotion.solver.package import read_package

G, L1, L2 = 9.81, 0.6, 0.5
OUTER, WALL, DENSITY, PAYLOAD = 0.025, 0.75e-3, 1600.0, 2.0
INNER = OUTER - WALL
PER_LENGTH = DENSITY * np.pi * (OUTER**2 - INNER**2)
ROTARY = DENSITY * np.pi * (OUTER**4 - INNER**4) / 4.0  # of the section, per length


@pytest.fixture(scope="module")
def found(repository, tmp_path_factory):
    runs = case_runs(repository, "robot-arm", tmp_path_factory.mktemp("build"))
    return {name: run_case(runs / f"{name}.json", t_end=0.4) for name in ("base", "rigid")}


def step(t, value):
    """Angle, rate and acceleration of a smooth step from 0.1 s over 0.8 s."""
    s = np.clip((t - 0.1) / 0.8, 0.0, 1.0)
    return (
        value * s**3 * (10 - 15 * s + 6 * s**2),
        value * 30 * s**2 * (1 - s) ** 2 / 0.8,
        value * 60 * s * (1 - s) * (1 - 2 * s) / 0.8**2,
    )


def motion(r, upper, fore):
    """Position and acceleration (2, k) of the forearm at a distance r from the elbow."""
    u = [np.array([np.cos(a), np.sin(a)]) for a, *_ in (upper, fore)]
    n = [np.array([-np.sin(a), np.cos(a)]) for a, *_ in (upper, fore)]
    place = L1 * u[0] + r * u[1]
    lengths = zip((L1, r), u, n, (upper, fore), strict=True)
    return place, sum(c * (dd * m - d**2 * e) for c, e, m, (_, d, dd) in lengths)


def torques(t):
    """Torques of shoulder and elbow (k,) of two rigid tubes and a point mass, by moments."""
    shoulder, elbow = step(t, np.pi / 3), step(t, -np.pi / 2)
    upper, fore = shoulder, tuple(a + b for a, b in zip(shoulder, elbow, strict=True))
    u = np.array([np.cos(upper[0]), np.sin(upper[0])])
    m_1, m_2 = PER_LENGTH * L1, PER_LENGTH * L2
    at_shoulder = (m_1 * L1**2 / 3 + ROTARY * L1) * upper[2] + m_1 * G * 0.5 * L1 * u[0]
    at_elbow = (m_2 * L2**2 / 12 + ROTARY * L2) * fore[2]
    at_shoulder = at_shoulder + at_elbow
    for mass, r in ((m_2, 0.5 * L2), (PAYLOAD, L2)):
        place, a = motion(r, upper, fore)
        force = mass * (a + np.array([[0.0], [G]]))
        arm = place - L1 * u
        at_shoulder = at_shoulder + place[0] * force[1] - place[1] * force[0]
        at_elbow = at_elbow + arm[0] * force[1] - arm[1] * force[0]
    return at_shoulder, at_elbow


def test_rigid_arm_moves_in_closed_form(found):
    t, s, _ = found["rigid"]
    upper, elbow = step(t, np.pi / 3)[0], step(t, -np.pi / 2)[0]
    x = L1 * np.cos(upper) + L2 * np.cos(upper + elbow)
    z = L1 * np.sin(upper) + L2 * np.sin(upper + elbow)
    np.testing.assert_allclose(s["tip_x"], x, atol=1e-9)
    np.testing.assert_allclose(s["tip_z"], z, atol=1e-9)
    np.testing.assert_allclose(s["tip_error"], 0.0, atol=1e-12)


def test_rigid_arm_keeps_mass_and_inertia_of_its_packages(found):
    """The torques of the whole motion: masses, centres and inertias of both tubes act in them."""
    t, s, _ = found["rigid"]
    shoulder, elbow = torques(t)
    np.testing.assert_allclose(s["shoulder_torque"], shoulder, rtol=2e-5)
    np.testing.assert_allclose(s["elbow_torque"], elbow, rtol=2e-5)


def test_equilibrium_holds_the_weights(found):
    """Before the drives move: weights times distances, which the sag does not change."""
    t, s, summary = found["base"]
    still = t < 0.099
    weight = PER_LENGTH * G
    shoulder = 0.5 * weight * (L1 + L2) ** 2 + PAYLOAD * G * (L1 + L2)
    elbow = 0.5 * weight * L2**2 + PAYLOAD * G * L2
    # distances change with the square of the slope, 4e-3
    np.testing.assert_allclose(s["shoulder_torque"][still], shoulder, rtol=5e-5)
    np.testing.assert_allclose(s["elbow_torque"][still], elbow, rtol=5e-5)
    assert np.ptp(s["sag"][still]) < 1e-3 * np.abs(s["sag"][0])
    assert summary["warnings"] == []


def test_sag_is_that_of_a_cantilever(repository, found):
    """Both tubes in line, of one section: a cantilever under its weight and the payload's."""
    K = read_package(repository / "tests/packages/robot-arm/upper.base.vtkhdf").sections[0].K
    compliance = np.linalg.inv(K)
    bending, shear = compliance[4, 4], compliance[2, 2]
    length, weight, force = L1 + L2, PER_LENGTH * G, PAYLOAD * G
    sag = bending * (force * length**3 / 3 + weight * length**4 / 8)
    sag += shear * (force * length + weight * length**2 / 2)
    _, s, _ = found["base"]
    assert s["sag"][0] == pytest.approx(-sag, rel=2e-3)
    assert s["tip_error"][0] == pytest.approx(sag, rel=2e-3)


def test_margins_follow_the_bending_moment(found):
    """Stresses at the root go with the moment there, and the forearm carries less."""
    _, s, summary = found["base"]
    assert (s["upper_margin"] < s["fore_margin"]).all()
    product = s["upper_margin"] * s["shoulder_torque"]
    assert np.ptp(product) < 0.15 * product.mean()
    worst = summary["strength"]["upper"]
    assert worst["ratio"] == pytest.approx(s["upper_margin"].min(), rel=1e-6)
    assert worst["x"] == 0.0


def test_case_file_is_short(repository):
    text = (repository / "cases/robot-arm/case.toml").read_text()
    assert len(text.splitlines()) < 120
