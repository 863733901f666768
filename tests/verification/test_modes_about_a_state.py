"""Modes about a state against closed forms, by the command `plymotion modes`."""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import carriage, force
from samples.modes_samples import modes_at, rates

POINT = 1e-9  # inertia of what should be a mass point [kg m2]


@pytest.fixture(scope="module")
def table(published):
    return published("modes")


def hinge(name, one, two, axis, more=""):
    return (
        f'[joints.{name}]\nkind = "revolute"\nbetween = ["{one}", "{two}"]\naxis = {axis}\n{more}\n'
    )


def ground(name, at):
    return f"[ground.{name}]\nposition = {list(map(float, at))}\n"


def turned(angle_deg, axis):
    return (np.array(axis) * angle_deg).tolist()


def test_lag_of_a_rod_on_a_spinning_hub(table, tmp_path, capsys):
    e = table["hub-rod"]
    own = e["inertia"] - e["mass"] * e["centre"] ** 2
    text = (
        ground("axis", (0, 0, 0))
        + rigid("hub", 1.0, 0.1, {"axis": (0, 0, 0), "rim": (e["hub_radius"], 0, 0)})
        + rigid(
            "rod", e["mass"], own, {"hinge": (-e["centre"], 0, 0)},
            position=[e["hub_radius"] + e["centre"], 0.0, 0.0],
        )
        + hinge("axis", "ground.axis", "hub.axis", [0, 0, 1], "drive = { speed = 3.0 }")
        + hinge("lag", "hub.rim", "rod.hinge", [0, 0, 1])
    )  # fmt: skip
    found = modes_at(tmp_path, text, f"spin={e['spin']}", capsys=capsys)
    assert rates(found) == pytest.approx([e["lag"]], rel=1e-9)
    assert found["spin"]["axis"] == pytest.approx([0, 0, 1])
    assert found["modes"][0]["bodies"] == pytest.approx({"hub": 0.0, "rod": 1.0})


def test_hanging_parallelogram_with_redundant_hinges(table, tmp_path, capsys):
    e = table["parallelogram"]
    m, M, L = e["upright"], e["coupler"], e["length"]
    J = m * L**2 / 12
    text = f"gravity = [0.0, -{e['gravity']}, 0.0]\n"
    for name, x in (("left", 0.0), ("right", 0.4)):
        text += ground(name, (x, 0, 0))
        ends = {"top": (0, 0.5 * L, 0), "end": (0, -0.5 * L, 0)}
        text += rigid(name, m, (J, 1e-3, J), ends, position=[x, -0.5 * L, 0.0])
    text += rigid("coupler", M, 0.01, {"a": (-0.2, 0, 0), "b": (0.2, 0, 0)}, position=[0.2, -L, 0])
    text += hinge("a", "ground.left", "left.top", [0, 0, 1])
    text += hinge("b", "ground.right", "right.top", [0, 0, 1])
    text += hinge("c", "left.end", "coupler.a", [0, 0, 1])
    text += hinge("d", "right.end", "coupler.b", [0, 0, 1])
    found = modes_at(tmp_path, text, "equilibrium", capsys=capsys)
    assert rates(found) == pytest.approx([e["w"]], rel=1e-8)
    assert found["constraints"]["rows"] - found["constraints"]["rank"] == 3
    assert found["constraints"]["largest_dropped"] < 1e-10


def rotor_text(e):
    text = rigid(
        "rotor", e["mass"], (e["transverse"], e["transverse"], e["polar"]),
        {"a": (0, 0, e["at"][0]), "b": (0, 0, e["at"][1])},
    )  # fmt: skip
    for name, z, k in zip("ab", e["at"], e["stiffness"], strict=True):
        text += ground(name, (0, 0, z)) + (
            f'[forces.{name}]\nkind = "bushing"\nbetween = ["ground.{name}", "rotor.{name}"]\n'
            f"stiffness = [{k}, {k}, 0.0]\n"
        )
    return text


def test_rigid_rotor_whirls(table, tmp_path, capsys):
    e = table["rotor"]
    text = rotor_text(e)
    still = modes_at(tmp_path, text, "equilibrium", capsys=capsys)
    assert rates(still) == pytest.approx(sorted(e["still"] * 2), rel=2e-6)
    spin = modes_at(tmp_path, text, f"spin={e['spin']}", "--axis", "0,0,1", capsys=capsys)
    whirl = [m["fixed_axes_angular_frequency"] for m in spin["modes"] if m["angular_frequency"] > 0]
    assert sorted(whirl) == pytest.approx(e["whirl"], rel=2e-6)
    assert sum(m["kind"] == "zero" for m in spin["modes"]) == 2  # along and about the axis


def test_rotor_that_starts_with_its_spin(table, tmp_path, capsys):
    """The spin of the start is recognised."""
    e = table["rotor"]
    text = rotor_text(e).replace("mass =", f"angular_velocity = [0.0, 0.0, {e['spin']}]\nmass =")
    found = modes_at(tmp_path, text, "start", capsys=capsys)
    whirl = [m["fixed_axes_angular_frequency"] for m in found["modes"]]
    assert sorted(w for w in whirl if w is not None) == pytest.approx(e["whirl"], rel=2e-6)


@pytest.mark.parametrize("first", [50.0, 70.0])
def test_bead_on_a_spinning_hoop(table, tmp_path, capsys, first):
    e = table["hoop"]
    text = (
        f"gravity = [0.0, 0.0, -{e['gravity']}]\n"
        + ground("axis", (0, 0, 0))
        + rigid("hoop", 1.0, 0.1, {"axis": (0, 0, 0)})
        + rigid(
            "bead", 2.0, POINT, {"centre": (0, 0, e["radius"])},
            position=[e["radius"] * np.sin(np.radians(first)), 0.0,
                      -e["radius"] * np.cos(np.radians(first))],
            rotation_deg=turned(-first, (0, 1, 0)),
        )
        + hinge("axis", "ground.axis", "hoop.axis", [0, 0, 1], "drive = { speed = 1.0 }")
        + hinge("bead", "hoop.axis", "bead.centre", [0, 1, 0])
        + '[signals.bead]\nkind = "position"\nat = "bead.centre"\ncomponent = "x"\n'
    )  # fmt: skip
    found = modes_at(tmp_path, text, f"spin={e['spin']}", capsys=capsys)
    assert rates(found) == pytest.approx([e["w"]], rel=2e-6)


def test_half_car(table, tmp_path, capsys):
    e = table["half-car"]
    text = rigid(
        "car", e["mass"], e["inertia"], {"front": (e["at"][0], 0, 0), "rear": (e["at"][1], 0, 0)}
    )
    for name, x, k in zip(("front", "rear"), e["at"], e["stiffness"], strict=True):
        text += ground(name, (x, 0, 0)) + (
            f'[forces.{name}]\nkind = "bushing"\nbetween = ["ground.{name}", "car.{name}"]\n'
            f"stiffness = [0.0, 0.0, {k}]\n"
        )
    found = modes_at(tmp_path, text, "start", capsys=capsys)
    assert rates(found) == pytest.approx(e["w"], rel=1e-5)
    assert sum(m["kind"] == "zero" for m in found["modes"]) == 4


@pytest.mark.parametrize(("share", "unstable"), [(0.9999, False), (1.0001, True)])
def test_ziegler_flutters_beyond_its_critical_load(table, tmp_path, capsys, share, unstable):
    load = share * table["ziegler"]["critical"]  # k = l = m = 1
    text = ground("foot", (0, 0, 0))
    for name, mass, x in (("one", 2.0, 1.0), ("two", 1.0, 2.0)):
        ends = {"near": (-1, 0, 0), "far": (0, 0, 0)}
        text += rigid(name, mass, POINT, ends, position=[x, 0.0, 0.0])
    for name, one, two in (("foot", "ground.foot", "one.near"), ("knee", "one.far", "two.near")):
        text += hinge(name, one, two, [0, 0, 1])
        text += (
            f'[forces.{name}]\nkind = "rotary_spring"\nbetween = ["{one}", "{two}"]\n'
            "axis = [0.0, 0.0, 1.0]\nstiffness = 1.0\n"
        )
    text += (
        '[forces.load]\nkind = "force"\nat = "two.far"\ndirection = [-1.0, 0.0, 0.0]\n'
        f'frame = "following"\nlaw = {{ constant = {load} }}\n'
    )
    found = modes_at(tmp_path, text, "start", capsys=capsys)
    assert any(m["damping_ratio"] < -1e-6 for m in found["modes"]) is unstable
    assert any("unstable" in note for note in found["notes"]) is unstable


def test_a_sampled_controller_is_held_and_a_note_says_so(tmp_path, capsys):
    """Mass, spring and damper; without sample_time the controller is a stiffness and a damper."""
    keys = {"setpoint": "0", "proportional": 300.0, "derivative": 4.0}
    spring = force("spring", "coordinate_force", joint="rail", expression="-100 * x - 2 * v")
    for period, note in ((0.001, True), (None, False)):
        sampled = {} if period is None else {"sample_time": period}
        text = carriage(spring, force("c", "controller", joint="rail", **keys, **sampled))
        found = modes_at(tmp_path, text, "equilibrium", capsys=capsys)
        k, c = (100.0, 2.0) if note else (400.0, 6.0)
        assert rates(found) == pytest.approx([np.sqrt(k - 0.25 * c**2)], rel=1e-6)
        told = [n for n in found["notes"] if n.startswith("c: sampled, so its output is held")]
        assert len(told) == note
