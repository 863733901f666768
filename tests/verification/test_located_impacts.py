"""Stops whose impacts are located: the restitution holds at any speed, none is missed."""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import DEFAULT, RADAU, carriage, force, run
from scipy.special import ellipk

from plymotion.solver.errors import InputError

G = 9.81


def stop(**keys) -> str:
    return force("stop", "limit_stop", **{"joint": "rail", "stiffness": 1e13, **keys})


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT])
@pytest.mark.parametrize("speed", [0.02, 3.0])
@pytest.mark.parametrize("restitution", [0.2, 0.7])
def test_a_free_mass_leaves_with_the_restitution(tmp_path, solver, speed, restitution):
    """One `restitution` for any speed, met after one long step."""
    text = carriage(stop(upper=speed / 2, restitution=restitution), speed=speed)
    _, s, summary = run(tmp_path, text, 1.0, 0.25, solver)
    loose = 2e-3 if solver == DEFAULT else 2e-6
    assert s["v"][-1] == pytest.approx(-restitution * speed, rel=loose)
    assert summary["checks"]["energy_drift_relative"] < loose


@pytest.mark.parametrize("solver", [RADAU, 'integrator = "rk8"\nrtol = 1e-8'])
def test_a_pendulum_bounces_at_its_lowest_point(tmp_path, solver):
    """Impacts at t_n, heights by e^2: quarter periods sqrt(l / g) K(sin(phi_n / 2)) between."""
    e, length, phi, inertia = 0.8, 0.5, 1.2, 0.02
    text = f"gravity = [0.0, {-G}, 0.0]\n" + (
        '[ground.O]\nposition = [0.0, 0.0, 0.0]\n[joints.pin]\nkind = "revolute"\n'
        'between = ["ground.O", "bob.a"]\n'
        '[signals.angle]\nkind = "joint"\njoint = "pin"\ncoordinate = "angle"\n'
        '[signals.w]\nkind = "angular_velocity"\nat = "bob.a"\ncomponent = "z"\n'
    )
    x, y = np.sin(phi), -np.cos(phi)
    text += rigid("bob", 2.0, inertia, {"a": (-length * x, -length * y, 0)},
                  position=(length * x, length * y, 0)) + force(
        "stop", "limit_stop", joint="pin", lower=-phi, stiffness=1e13, restitution=e
    )  # fmt: skip
    heights = (1.0 - np.cos(phi)) * e ** (2 * np.arange(5))
    tops = np.arccos(1.0 - heights)
    quarters = np.sqrt((length + inertia / (2.0 * length)) / G) * ellipk(np.sin(tops / 2) ** 2)
    hits = quarters[0] + np.concatenate([[0.0], np.cumsum(2 * quarters[1:])])
    t, s, summary = run(tmp_path, text, hits[3] + quarters[4], quarters[4] / 2000, solver)
    up = s["w"] > 0
    found = t[1:][up[1:] & ~up[:-1]]
    np.testing.assert_allclose(found, hits[:4], atol=quarters[4] / 1000)
    assert s["angle"][-1] + phi == pytest.approx(tops[4], abs=2e-5)
    assert abs(s["w"][-1]) < 2e-3
    assert summary["checks"]["energy_drift_relative"] < 1e-5


def test_bounces_become_rest(tmp_path):
    """A ball that bounces lower and lower comes to rest on its floor, at its static depth."""
    text = carriage(
        stop(lower=-0.05, restitution=0.5, stiffness=1e6, exponent=1.0),
        force("weight", "coordinate_force", joint="rail", expression="-9.81"),
    )
    _, s, summary = run(tmp_path, text, 1.0, 0.5, DEFAULT)
    assert s["x"][-1] == pytest.approx(-0.05 - 9.81 / 1e6, abs=1e-6)
    assert abs(s["v"][-1]) < 1e-3
    assert summary["cost"]["steps"] < 3000


def test_both_limits_are_met_in_turn(tmp_path):
    """Between two walls: after n impacts e^n of the speed, at the sum of the ways over them."""
    text = carriage(stop(lower=-0.5, upper=0.5, restitution=0.9), speed=2.0)
    t_end = 0.25 + 0.5 / 0.9 + 0.5 / 0.81 + 0.1
    _, s, _ = run(tmp_path, text, t_end, t_end / 2, RADAU)
    assert s["v"][-1] == pytest.approx(-2.0 * 0.9**3, rel=1e-5)
    assert s["x"][-1] == pytest.approx(0.5 - 0.1 * 2.0 * 0.9**3, abs=3e-4)


def test_bad_input(tmp_path):
    text = carriage(stop(upper=1.0, restitution=0.5), speed=2.0)
    with pytest.raises(InputError, match="stop at the instants of impacts"):
        run(tmp_path, text, 0.1, 0.1, 'integrator = "gear"')


@pytest.mark.parametrize("stiffness", [1e6, 1e9])
def test_instants_settle_at_a_loose_tolerance(tmp_path, stiffness):
    """Passes that locate an impact differ by what Newton's iteration leaves: they went on for ever.

    A double pendulum whose second pin is stopped on both sides.
    """
    ends = {"a": (-0.5, 0, 0), "b": (0.5, 0, 0)}
    text = f"gravity = [0.0, {-G}, 0.0]\n[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    for k, (one, two) in enumerate((("ground.O", "rod0.a"), ("rod0.b", "rod1.a"))):
        text += rigid(f"rod{k}", 1.0, (0.001, 0.08, 0.08), ends, position=(k + 0.5, 0, 0))
        text += f'[joints.pin{k}]\nkind = "revolute"\nbetween = ["{one}", "{two}"]\n'
    text += '[signals.bend]\nkind = "joint"\njoint = "pin1"\ncoordinate = "angle"\n'
    text += force("stop", "limit_stop", joint="pin1", lower=-1.0, upper=0.3,
                  stiffness=stiffness, restitution=0.5)  # fmt: skip
    _, s, summary = run(tmp_path, text, 10.0, 0.01, 'integrator = "radau"\nrtol = 1e-3')
    assert summary["completed"]
    assert summary["cost"]["steps"] < 2000
    assert s["bend"].min() > -1.01
    assert s["bend"].max() < 0.31
