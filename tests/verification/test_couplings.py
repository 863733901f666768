"""Gears, belts, screws and racks: rows against differences, closed forms, no net work."""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import DEFAULT, RADAU, force, prepared, run

from plymotion.solver.dynamics.analysis.recovery import momentum_balance
from plymotion.solver.dynamics.evaluation import series
from plymotion.solver.dynamics.evaluation.accelerations import assemble
from plymotion.solver.dynamics.model.coordinates import moved
from plymotion.solver.errors import InputError

GROUND = "[ground.O]\nposition = [0.0, 0.0, 0.0]\n[ground.P]\nposition = [1.0, 0.0, 0.0]\n"


def joint(name, kind, one, two, axis=(0.0, 0.0, 1.0)):
    return f'[joints.{name}]\nkind = "{kind}"\nbetween = ["{one}", "{two}"]\naxis = {list(axis)}\n'


def coupling(name, kind, one, two, **keys):
    more = "\n".join(f"{key} = {value}" for key, value in keys.items())
    return f'[couplings.{name}]\nkind = "{kind}"\njoints = ["{one}", "{two}"]\n{more}\n'


def angle(name):
    return f'[signals.{name}]\nkind = "joint"\njoint = "{name}"\ncoordinate = "angle"\n'


def wheels(kind="gear_pair", **keys):
    """Two wheels on the ground; a torque of 3 N m on the first."""
    return (
        GROUND
        + rigid("one", 1.0, 0.2, {"a": (0, 0, 0)})
        + rigid("two", 1.0, 0.5, {"a": (0, 0, 0)}, position=(1, 0, 0))
        + joint("axle_1", "revolute", "ground.O", "one.a")
        + joint("axle_2", "revolute", "ground.P", "two.a")
        + coupling("gear", kind, "axle_1", "axle_2", **keys)
        + force("motor", "coordinate_force", joint="axle_1", expression="3")
        + angle("axle_1")
        + angle("axle_2")
    )


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT])
@pytest.mark.parametrize(
    ("kind", "keys", "ratio"),
    [
        ("gear_pair", {"ratio": -2.5}, -2.5),
        ("belt", {"radius_1": 0.1, "radius_2": 0.3}, 3.0),
        ("belt", {"radius_1": 0.1, "radius_2": -0.05}, -0.5),
    ],
)
def test_two_wheels(tmp_path, kind, keys, ratio, solver):
    """Many turns: (J1 + J2 / n^2) angle'' = M."""
    t, s, summary = run(tmp_path, wheels(kind, **keys), 3.0, 0.3, solver)
    expected = 0.5 * 3.0 / (0.2 + 0.5 / ratio**2) * t**2
    assert expected[-1] > 5.0
    loose = 1e-3 if solver == DEFAULT else 1e-6
    np.testing.assert_allclose(s["axle_1"], expected, rtol=loose, atol=loose)
    np.testing.assert_allclose(s["axle_2"], s["axle_1"] / ratio, rtol=1e-9, atol=1e-9)
    assert summary["checks"]["energy_drift_relative"] < loose
    assert summary["checks"]["drive_work"] == pytest.approx(3.0 * s["axle_1"][-1], rel=loose)
    assert summary["warnings"] == []


def carrier(ratio=-3.0):
    """A carrier about z with two wheels on it, on axles that are not parallel, geared."""
    return (
        GROUND
        + rigid("arm", 2.0, (0.3, 0.4, 0.5), {"a": (0, 0, 0), "b": (0.4, 0, 0), "c": (0, 0.3, 0)})
        + rigid("one", 1.0, (0.1, 0.1, 0.2), {"a": (0, 0, 0)}, position=(0.4, 0, 0))
        + rigid("two", 1.0, (0.2, 0.3, 0.2), {"a": (0, 0, 0)}, position=(0, 0.3, 0))
        + joint("main", "revolute", "ground.O", "arm.a")
        + joint("axle_1", "revolute", "arm.b", "one.a")
        + joint("axle_2", "revolute", "arm.c", "two.a", (0.0, 1.0, 0.0))
        + coupling("gear", "gear_pair", "axle_1", "axle_2", ratio=ratio)
        + force("motor", "coordinate_force", joint="axle_1", expression="3 - 0.2 * t")
        + force("turn", "coordinate_force", joint="main", expression="2")
        + angle("axle_1")
        + angle("axle_2")
    )


@pytest.mark.parametrize("solver", ["", RADAU])
def test_three_bodies(tmp_path, solver):
    """Wheels on a moving carrier: ratio, energy, and momentum with the loads of all markers."""
    _, s, summary = run(tmp_path, carrier(), 3.0, 0.1, solver)
    assert abs(s["axle_1"][-1]) > 2 * np.pi
    np.testing.assert_allclose(s["axle_1"], -3.0 * s["axle_2"], rtol=1e-8, atol=1e-8)
    assert summary["checks"]["energy_drift_relative"] < (1e-10 if not solver else 1e-6)
    assert summary["checks"]["momentum_balance"] < 1e-8


def test_lead_and_radius(tmp_path):
    """Spindle and nut: J w' = M - F lead / 2 pi, and a pinion on the same rack."""
    text = (
        GROUND
        + rigid("spindle", 1.0, 0.02, {"a": (0, 0, 0)})
        + rigid("nut", 4.0, 0.1, {"a": (0, 0, 0)}, position=(1, 0, 0))
        + rigid("pinion", 1.0, 0.01, {"a": (0, 0, 0)})
        + joint("axle", "revolute", "ground.O", "spindle.a")
        + joint("rail", "prismatic", "ground.P", "nut.a", (1.0, 0.0, 0.0))
        + joint("shaft", "revolute", "ground.O", "pinion.a")
        + coupling("screw", "screw_drive", "axle", "rail", lead=0.01)
        + coupling("rack", "rack", "shaft", "rail", radius=-0.05)
        + force("motor", "coordinate_force", joint="axle", expression="0.7")
        + force("load", "coordinate_force", joint="rail", expression="-50")
        + angle("axle")
        + angle("shaft")
        + '[signals.z]\nkind = "joint"\njoint = "rail"\ncoordinate = "z"\n'
    )
    t, s, _ = run(tmp_path, text, 2.0, 0.5)
    per = 0.01 / (2 * np.pi)
    turning = (0.7 - 50 * per) / (0.02 + 4.0 * per**2 + 0.01 * (per / 0.05) ** 2)
    np.testing.assert_allclose(s["axle"], 0.5 * turning * t**2, rtol=1e-8)
    np.testing.assert_allclose(s["z"], per * s["axle"], rtol=1e-9)
    np.testing.assert_allclose(s["shaft"], -s["z"] / 0.05, rtol=1e-9)


def test_rows_against_differences(tmp_path):
    """Jacobian and gamma of the row, with all bodies turned and in motion."""
    model, y = prepared(tmp_path, carrier())
    rng = np.random.default_rng(3)
    n, row = model.n_pos, int(model.joint_row[-2])
    y[:n] = moved(model, y[:n], 0.3 * rng.normal(size=model.n_vel))
    y[n : n + model.n_vel] = rng.normal(size=model.n_vel)

    def phi(step):
        near = y.copy()
        near[:n] = moved(model, y[:n], step)
        return assemble(model, 0.0, near).Phi[row]

    h, here = 1e-4, assemble(model, 0.0, y)
    for e in h * np.eye(model.n_vel):
        slope = (8 * (phi(e) - phi(-e)) - phi(2 * e) + phi(-2 * e)) / (12 * h)
        assert here.Phi_q[row, np.argmax(e)] == pytest.approx(slope, abs=1e-9)
    # along a motion of constant coordinate velocities: Phi'' = -gamma
    v, h = y[n : n + model.n_vel], 1e-2
    values = np.array([phi(k * h * v) for k in range(-3, 4)])
    bend = np.array([2, -27, 270, -490, 270, -27, 2]) @ values / (180 * h**2)
    assert here.gamma[row] == pytest.approx(-bend, rel=1e-6)
    assert abs(bend) > 1e-2


def test_loads_of_couplings(tmp_path):
    """They are in the balance of momentum, and their powers cancel."""
    model, y = prepared(tmp_path, carrier())
    found = momentum_balance(model, np.zeros(1), y[None])
    assert max(found.linear, found.angular) < 1e-9
    _, multipliers = series.along_solution(model, np.zeros(1), y[None])
    loads = series.marker_loads(model, np.zeros(1), y[None], multipliers)[0]
    gear = loads[-4:]  # both markers of both coordinates
    assert np.abs(gear[0, 5]) > 0.1
    np.testing.assert_allclose(gear[1, 3:], -gear[0, 3:], atol=1e-12)
    assert gear[3, 4] == pytest.approx(3.0 * gear[1, 5], rel=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("ratio = -2.5", "ratio = 0", "couplings.gear.ratio = 0"),
        ("ratio = -2.5", "", "couplings.gear.ratio: missing"),
        ("ratio = -2.5", "ratoi = 1.0", "did you mean 'ratio'"),
        ('"axle_1", "axle_2"]', '"axle_1", "axel_2"]', "no such joint; did you mean 'axle_2'"),
        ('"axle_1", "axle_2"]', '"axle_1", "axle_1"]', "expected two different coordinates"),
        ('kind = "gear_pair"', 'kind = "gaer_pair"', "did you mean 'gear_pair'"),
        ("ratio = -2.5", 'ratio = 1.0\ncoordinates = ["angle", "z"]', "one of angle"),
    ],
)
def test_bad_input(tmp_path, old, new, words):
    text = wheels(ratio=-2.5)
    assert old in text
    with pytest.raises(InputError) as caught:
        run(tmp_path, text.replace(old, new), 0.1, 0.1)
    assert words in str(caught.value)


def sized(name, of):
    return f'[signals.{name}]\nkind = "force"\nof = "{of}"\n'


def test_signals_of_a_force_and_of_what_a_gear_transmits(tmp_path):
    """The gear takes M - J1 angle'' off the first wheel; the motor's law is a growing torque."""
    text = wheels("gear_pair", ratio=-2.5).replace('expression = "3"', 'expression = "3 * t"')
    text += sized("motor", "motor") + sized("gear", "gear")
    t, s, summary = run(tmp_path, text, 1.0, 0.1, RADAU)
    np.testing.assert_allclose(s["motor"], 3.0 * t, atol=1e-12)
    taken = -3.0 * t * (1.0 - 0.2 / (0.2 + 0.5 / 2.5**2))
    np.testing.assert_allclose(s["gear"], taken, atol=1e-9)
    assert summary["signals"]["gear"]["unit"] == "N m"
    with pytest.raises(InputError, match=r'signals.bad.of = "gaer": no such force .*gear'):
        run(tmp_path, text + sized("bad", "gaer"), 1.0, 0.1, RADAU)
