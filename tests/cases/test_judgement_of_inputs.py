"""Findings about the numbers of a case: units of materials, splines through tables."""

from dataclasses import replace

import pytest
from samples.case_samples import rigid
from samples.judged_samples import judged
from samples.package_samples import cantilever

FREE = """
[bodies.bar]
kind = "package"
package = "bar.vtkhdf"
"""
ALUMINIUM = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}
CARBON = {"kind": "orthotropic", "E1": 140e9, "E2": 9e9, "E3": 9e9, "rho": 1600.0}


def found_with(folder, materials):
    """Codes and messages of a run whose body is made of these materials."""
    spec = {"kind": "beam", "sections": [{"mesh": {}, "materials": materials}]}
    package = cantilever()
    package = replace(package, provenance={**package.provenance, "spec": spec})
    found = judged(folder, FREE, {"bar": package}, t_end=0.01)
    return [w["message"] for w in found.summary["warnings"] if w["code"] == "material-units"]


@pytest.mark.provokes("material-units")
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"E": 70.0}, "0.16 m/s"),  # GPa
        ({"E": 70e3}, "5.1 m/s"),  # MPa
        ({"rho": 2.7}, "1.6e+05 m/s"),  # g/cm3
    ],
)
def test_moduli_and_densities_in_other_units(tmp_path, change, words):
    (message,) = found_with(tmp_path, {"metal": ALUMINIUM | change, "ply": CARBON})
    assert "bar: material metal has E" in message, "material-units"
    assert words in message


def test_plies_in_megapascal(tmp_path):
    (message,) = found_with(tmp_path, {"metal": ALUMINIUM | {"E": 70e3, "rho": 2.7e-9}})
    assert "5.1e+06 m/s" in message  # MPa and t/mm3
    fast = {"E1": 400e3, "E2": 7e3, "E3": 7e3, "rho": 1700.0}  # the stiffest, in MPa
    (message,) = found_with(tmp_path, {"ply": CARBON | fast})
    assert "15 m/s" in message


def test_soft_light_and_stiff_materials_are_no_mistakes(tmp_path):
    light = {"kind": "isotropic", "nu": 0.3}
    known = {
        "steel": light | {"E": 210e9, "rho": 7850.0},
        "diamond": light | {"E": 1050e9, "rho": 3500.0},
        "balsa": CARBON | {"E1": 3.5e9, "E2": 60e6, "E3": 60e6, "rho": 150.0},
        "honeycomb": CARBON | {"E1": 1e5, "E2": 1e5, "E3": 0.6e9, "rho": 48.0},
        "soft honeycomb, in its plane only": CARBON | {"E1": 1e5, "E2": 1e5, "E3": 1e5, "rho": 48},
        "soft foam": light | {"E": 0.1e6, "rho": 30.0},
        "rubber": light | {"E": 1e6, "rho": 1100.0},
        "void": light | {"E": 1.0, "rho": 1e-3},
        "void without inertia": light | {"E": 1e6, "rho": 1e-6},
        "of a file without density": light | {"E": 70e9, "rho": 0.0},
    }
    assert found_with(tmp_path, known) == []


def test_constants_of_one_material_in_different_units(tmp_path):
    ply = CARBON | {"G12": 5.0, "G13": 5.0, "G23": 3.5}  # GPa beside Pa
    (message,) = found_with(tmp_path, {"ply": ply})
    assert "1.4e+11 and 3.5 Pa" in message
    strong = ALUMINIUM | {"strength": {"yield_stress": 250.0}}  # MPa
    (message,) = found_with(tmp_path, {"metal": strong})
    assert "7e+10 and 250 Pa" in message
    (message,) = found_with(tmp_path, {"metal": ALUMINIUM | {"E": 70.0, "rho": 2.7}})
    assert "5.1 m/s" in message
    assert found_with(tmp_path, {"example": ALUMINIUM | {"E": 100.0, "rho": 1.0}}) == []


def sized(folder, text, **changes):
    """Messages of `size-units` of a run of these bodies."""
    package = replace(cantilever(), **changes)
    found = judged(folder, text, {"bar": package}, t_end=0.01)
    return [w["message"] for w in found.summary["warnings"] if w["code"] == "size-units"]


@pytest.mark.provokes("size-units")
def test_sizes_and_masses_in_other_units(tmp_path):
    assert sized(tmp_path, FREE) == []
    (section,) = cantilever().sections
    points = 1e3 * section.recovery.points  # 60 by 30 mm, in m
    wide = [replace(section, recovery=replace(section.recovery, points=points))]
    (beam,) = sized(tmp_path, FREE, sections=tuple(wide))
    assert "bar: the beam is" in beam, "size-units"
    assert "1.501 m long" in beam
    assert sized(tmp_path, 'allow = ["size-units"]' + FREE, sections=tuple(wide)) == []
    heavy = rigid("block", 2e8, 1e8, {"centre": (0, 0, 0)})
    (message,) = sized(tmp_path, FREE + heavy)
    assert "block: the mass is 2e+08 kg" in message
    rod = rigid("block", 1.0, 1e6 / 12.0, {"centre": (0, 0, 0)})  # 1 m, in kg mm2
    (message,) = sized(tmp_path, FREE + rod)
    assert "kg mm2" in message
    (message,) = sized(tmp_path, "gravity = [0.0, -9810.0, 0.0]\n" + FREE)
    assert message.startswith("gravity: 9810 m/s2")


TURNS = """
[ground.o]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.o", "wheel.centre"]
[forces.stop]
kind = "limit_stop"
joint = "hinge"
upper = 90.0
stiffness = 1e3
[joints.slide]
kind = "prismatic"
between = ["ground.o", "sled.centre"]
[forces.end]
kind = "limit_stop"
joint = "slide"
upper = 90.0
stiffness = 1e3
"""


@pytest.mark.provokes("angle-units")
def test_limits_in_degrees(tmp_path):
    bodies = (rigid(name, 1.0, 1.0, {"centre": (0, 0, 0)}) for name in ("wheel", "sled"))
    text = "".join(bodies) + TURNS
    (said,) = (
        w["message"]
        for w in judged(tmp_path, text, t_end=0.01).summary["warnings"]
        if w["code"] == "angle-units"
    )
    assert said.startswith("forces.stop.upper = 90 rad are 14.3 turns"), "angle-units"
    meant = judged(tmp_path, 'allow = ["angle-units"]\n' + text, t_end=0.01)
    assert "angle-units" not in meant.codes


@pytest.mark.parametrize(
    ("law", "warned"),
    [
        ("smooth_step = { value = 180, duration = 1 }", True),
        ("table = { times = [0, 1, 2], values = [0, 90, 180] }", True),
        ("table = { times = [0, 1, 2], values = [0, 90, 181] }", False),
    ],
)
def test_drives_in_degrees(tmp_path, law, warned):
    bodies = (rigid(name, 1.0, 1.0, {"centre": (0, 0, 0)}) for name in ("wheel", "sled"))
    text = "".join(bodies) + TURNS.replace("upper = 90.0", "upper = 9.0")
    found = judged(tmp_path, text + f"[joints.hinge.drive]\n{law}\n", t_end=0.01)
    assert ("angle-units" in found.codes) == warned


def test_what_is_meant_is_accepted(tmp_path):
    spec = {"materials": {"gel": ALUMINIUM | {"E": 100.0, "rho": 1000.0}}}
    package = cantilever()
    for allowed, count in (({}, 1), ({"allow": ["material-units"]}, 0)):
        provenance = {**package.provenance, "spec": {"sections": [spec | allowed]}}
        soft = replace(package, provenance=provenance)
        found = judged(tmp_path, FREE, {"bar": soft}, t_end=0.01)
        assert found.codes.count("material-units") == count
    bare = replace(package, provenance={**package.provenance, "spec": {"sections": [spec]}})
    found = judged(tmp_path, 'allow = ["material-units"]' + FREE, {"bar": bare}, t_end=0.01)
    assert "material-units" not in found.codes


PUSHED = """
[forces.push]
kind = "force"
at = "block.centre"
direction = [1.0, 0.0, 0.0]
law = { table = { times = [0.0, 0.5, 0.52, 0.54, 2.0], values = [0.0, 0.0, 50.0, 0.0, 0.0]%s } }
[signals.x]
kind = "position"
at = "block.centre"
component = "x"
"""
BLOCK = rigid("block", 2.0, 1.0, {"centre": (0, 0, 0)})


@pytest.mark.provokes("table-overshoots")
def test_a_spline_through_a_short_pulse(tmp_path):
    """By default a load follows straight lines: the impulse is half of 50 N times 0.04 s."""
    spline = judged(tmp_path, BLOCK + PUSHED % ', interpolation = "spline"', t_end=2.0)
    assert spline.finding("table-overshoots")["value"] > 2.0
    assert "forces.push.law.table: " in spline.finding("table-overshoots")["message"]
    away = 0.5 * 50.0 * 0.04 / 2.0 * (2.0 - 0.52)
    for name, keys in {"absent": "", "pchip": ', interpolation = "pchip"'}.items():
        (tmp_path / name).mkdir()
        plain = judged(tmp_path / name, BLOCK + PUSHED % keys, t_end=2.0)
        assert "table-overshoots" not in plain.codes
        assert plain.summary["signals"]["x"]["final"] == pytest.approx(away, rel=1e-4)
    assert spline.summary["signals"]["x"]["final"] < -2.0 * away  # another motion


def test_tables_of_drives_springs_and_expressions(tmp_path):
    ground = "[ground.wall]\nposition = [0.0, 0.0, 0.0]\n"
    steps = "[0.0, 0.0, 1.0, 1.0]"
    text = (
        BLOCK
        + ground
        + f"""
[joints.slide]
kind = "prismatic"
between = ["ground.wall", "block.centre"]
axis = [1.0, 0.0, 0.0]
drive = {{ table = {{ times = [0.0, 0.4, 0.6, 1.0], values = {steps} }} }}
[tables.curve]
x = [0.0, 0.4, 0.6, 1.0]
y = {steps}
[forces.stop]
kind = "nonlinear_spring"
joint = "slide"
force_displacement = {{ x = [0.0, 0.4, 0.6, 1.0], y = {steps} }}
[forces.wind]
kind = "coordinate_force"
joint = "slide"
expression = "curve(t)"
"""
    )
    found = judged(tmp_path, text).summary["warnings"]
    keys = [w["message"].partition(":")[0] for w in found if w["code"] == "table-overshoots"]
    assert keys == ["joints.slide.drive.table", "forces.stop.force_displacement", "tables.curve"]
    kinder = text.replace(f"{steps} ", f'{steps}, interpolation = "pchip" ', 1)
    found = judged(tmp_path, kinder).summary["warnings"]
    assert not any("joints" in w["message"] for w in found if w["code"] == "table-overshoots")
