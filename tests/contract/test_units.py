"""Units of lengths: every key of a file has its unit, and every length of a file is converted."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import checked_case
from plymotion.solver.inputs.case.tables.kinds import ALONG
from plymotion.solver.inputs.case.tables.laws import TranslationDrive
from plymotion.solver.inputs.case.tables.schema import CaseFile, Mechanism
from plymotion.solver.inputs.json_schema import FILES, tables
from plymotion.solver.inputs.section.description import checked as section
from plymotion.solver.inputs.shell import Load
from plymotion.solver.inputs.shell import checked as shell
from plymotion.solver.inputs.solid_specification import solid_table

ROOT = Path(__file__).parents[2]
# Numbers without a unit: counts, ratios, and those whose unit is that of something else.
PURE = {
    "accuracy",
    "at",
    "atol_position",
    "atol_velocity",
    "beta0",
    "bounds",
    "cd",
    "cl",
    "cm",
    "coefficient",
    "coordinate",
    "count",
    "degree",
    "design",
    "difference",
    "divide_by",
    "drilling_factor",
    "exponent",
    "factor",
    "format",
    "frequencies",
    "from",
    "gear_ratio",
    "joints",
    "kind",
    "max",
    "min",
    "modal_coordinates",
    "offset",
    "parameters",
    "penalty",
    "ply",
    "ratio",
    "restitution",
    "rtol",
    "set",
    "share",
    "shear_correction",
    "shear_exponent",
    "size",  # of a state, in the unit of its expressions
    "spectral_radius",
    "start",
    "static_coefficient",
    "step",
    "sweeps",
    "to",
    "tolerance",
    "values",
    "x",
    "y",
}
# Units that are lengths in some tables: those tables convert them themselves.
SOMETIMES = {
    ALONG: ("lower", "upper", "length"),
    "m, rad, m/s, rad/s": ("x",),  # of force_displacement
    "m, m/s, ...": TranslationDrive.more_lengths,
    "rad, m, N or N m": ("value",),  # of TranslationDrive's smooth_step
    "m, rad": ("motion",),
    "m2, m": ("trapeze",),  # of matrices by hand, in SI
}


@pytest.fixture(scope="module")
def keys() -> dict[str, dict[str, Any]]:
    """Every key of every table, by table and name."""
    return {
        f"{table}.{key}": item
        for table, schema in tables([CaseFile, Mechanism, *FILES.values()])[1].items()
        for key, item in schema.get("properties", {}).items()
    }


def numeric(item: dict[str, Any]) -> bool:
    options = [item, *item.get("anyOf", ()), item.get("items", {})]
    return any(each.get("type") == "number" for each in options)


def test_every_number_has_a_unit_or_is_known_to_have_none(keys: dict[str, Any]) -> None:
    without = {name for name, item in keys.items() if numeric(item) and not item.get("unit")}
    assert {name.partition(".")[2] for name in without} <= PURE


def test_every_unit_that_may_be_a_length_is_converted_by_its_table(keys: dict[str, Any]) -> None:
    found = {
        (name.partition(".")[2], item["unit"])
        for name, item in keys.items()
        if item.get("unit", "").replace(",", " ").split()[:1] != ["m"] or item["unit"] != "m"
        if "m" in item.get("unit", "").replace(",", " ").split()
    }
    odd = {(key, unit) for key, unit in found if unit in SOMETIMES and key in SOMETIMES[unit]}
    # "N m" and the like are moments, which no table converts
    moments = {pair for pair in found if "N m" in pair[1] and pair[1] not in SOMETIMES}
    assert found == odd | moments | {("mass", "kg/m, kg, kg m")}
    assert Load.more_lengths == ("motion.ux", "motion.uy", "motion.uz")


CASE = """
format = 1
title = "lengths"
units = "{unit}"
gravity = [0.0, -9.81, 0.0]
parameters = { half = {0.25} }
materials.al = "al-6061-t6"
sections.box = { shape = "box", width = {0.04}, height = {0.03}, wall = {0.002} }
runs.base = {}
[sections.own.description]
convention = "contour"
mesh = { shape = "tube", outer_radius = {0.03} }
laminates.wall = { material = "al", angles_deg = [0, 0], ply_thickness = {0.0004} }
regions.all = { laminate = "wall" }
[bodies.arm]
kind = "beam"
length = "2*half"
section = "box"
material = "al"
position = [{0.1}, 0.0, 0.0]
velocity = [0.0, 0.1, 0.0]
modes = [{ kind = "lowest", count = 2 }]
interfaces = { root = { at = "start" }, tip = { at = "end" } }
[bodies.fore]
kind = "beam"
line = { points = [[0, 0, 0], [{0.2}, {0.05}, 0.0], [{0.5}, 0.0, 0.0]] }
section = "own"
modes = [{ kind = "lowest", count = 2 }]
interfaces = { root = { at = "start" } }
[bodies.block]
kind = "rigid"
mass = 2.0
inertia = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
centre = [{0.01}, 0.0, 0.0]
interfaces = { pin = { position = [{0.02}, 0.0, 0.0] } }
[ground.o]
position = [{0.1}, 0.0, 0.0]
[joints.slide]
kind = "prismatic"
between = ["ground.o", "block.pin"]
drive = { table = { times = [0, 1], values = [0, {0.3}] } }
[joints.turn]
kind = "revolute"
between = ["ground.o", "arm.root"]
[joints.rail]
free = ["y"]
between = ["ground.o", "fore.root"]
[forces.stop]
kind = "limit_stop"
joint = "rail"
lower = {-0.05}
stiffness = 1e5
[forces.turn_stop]
kind = "limit_stop"
joint = "turn"
lower = -0.5
stiffness = 1e3
[forces.guide]
kind = "friction"
joint = "rail"
coefficient = 0.1
length = {0.2}
rest_velocity = 0.01
[forces.motor]
kind = "controller"
joint = "rail"
setpoint = "0.1*t"
proportional = 10.0
upper = 4.0
[forces.spring]
kind = "nonlinear_spring"
between = ["ground.o", "arm.tip"]
length = {0.4}
force_displacement = { x = [{-0.1}, {0.2}], y = [-10, 20], interpolation = "linear" }
[signals.bend]
kind = "resultant"
body = "arm"
x = {0.25}
component = "M2"
[solver]
t_end = 1.0
output_step = 0.1
[sweeps.reach]
run = "base"
set = { "bodies.fore.line.points.2.0" = "2*a + {0.1}" }
[sweeps.reach.vary]
a = [{0.1}, {0.2}]
"ground.o.position.0" = [{0.1}]
"""


def in_unit(text: str, unit: str, metres: float) -> dict[str, Any]:
    """Return a file whose lengths, such as {0.5} [m], are in a unit."""

    def value(found: re.Match[str]) -> str:
        return repr(float(found[1]) / metres)

    return tomllib.loads(re.sub(r"\{(-?[\d.]+)\}", value, text.replace("{unit}", unit)))


def near(one: object, two: object) -> bool:
    """Whether plain data agree, numbers to rounding."""
    if isinstance(one, dict) and isinstance(two, dict):
        return one.keys() == two.keys() and all(near(one[k], two[k]) for k in one)
    if isinstance(one, list) and isinstance(two, list):
        return len(one) == len(two) and all(map(near, one, two))
    if isinstance(one, float) and isinstance(two, float):
        return one == pytest.approx(two, rel=1e-14)
    return bool(one == two)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("in", 0.0254)])
def test_a_case_in_another_unit_is_the_same_case(unit: str, metres: float) -> None:
    one, other = (
        checked_case(in_unit(CASE, *u), ROOT / "case.toml") for u in (("m", 1.0), (unit, metres))
    )
    first, second = (case.runs["base"].model_dump() for case in (one, other))
    for each in (first, second):  # what is still to be read with its own unit
        each.pop("sections"), each.pop("parameters")
    assert near(first, second)
    assert second["bodies"]["arm"]["length"] == pytest.approx(0.5)
    for name in ("arm", "fore"):
        assert near(one.bodies["base"][name].content, other.bodies["base"][name].content)
    swept, again = one.sweeps["reach"], other.sweeps["reach"]
    assert near(swept.own.changes, again.own.changes)
    assert [p.unit for p in again.parameters] == ["", unit]
    assert again.points[0, 1] == pytest.approx(0.1 / metres)


def test_a_parameter_is_not_read_in_two_units() -> None:
    table = in_unit(CASE, "mm", 1e-3)
    table["forces"]["pull"] = {
        "kind": "force", "at": "arm.tip", "direction": [1, 0, 0], "law": {"expression": "3*half"},
    }  # fmt: skip
    with pytest.raises(InputError, match="a length in mm by the parameter half, which a force"):
        checked_case(table, ROOT / "case.toml")
    checked_case({**table, "units": "m"}, ROOT / "case.toml")


def test_numbers_that_a_sweep_cannot_convert_are_refused() -> None:
    table = in_unit(CASE, "mm", 1e-3)
    table["sweeps"]["reach"] = {"run": "base", "vary": {"forces.stop.lower": [-10.0]}}
    with pytest.raises(InputError, match=r'forces.stop.lower: is in mm here; expected units = "m"'):
        checked_case(table, ROOT / "case.toml")


SECTION = """
format = 1
units = "{unit}"
title = "box"
convention = "contour"
mesh = { shape = "rectangle", width = {0.02}, height = {0.0008}, elements_2 = 8 }
materials.ply = { library = "as4-3501-6", rho = 1600.0 }
laminates.wall = { material = "ply", angles_deg = [0, 90], ply_thickness = {0.0004} }
regions.all = { laminate = "wall" }
"""
SHELL = """
format = 1
units = "{unit}"
title = "plate"
mesh = { shape = "plate", parameters = { length = {0.3}, width = {0.1} } }
materials.ply = "al-6061-t6"
regions.plate = { material = "ply", thickness = {0.002}, offset = {0.001} }
supports.left = { at = "left", fixed = "all" }
loads.pull.end = { at = "left", motion = { ux = {0.001}, ry = 0.1 } }
probes.end = { near = [{0.3}, 0.0, 0.0], what = "uz" }
"""
SOLID = """
units = "{unit}"
mesh = { file = "{part}", size = {0.005} }
materials.al = "al-6061-t6"
regions.all = { material = "al" }
interfaces.bore = { bore = { radius = {0.004}, point = [{0.015}, 0, 0], direction = [0, 0, 1] } }
"""


def test_descriptions_in_mm() -> None:
    file = ROOT / "x.toml"
    for text, read in ((SECTION, section), (SHELL, shell)):
        one, other = (
            read(in_unit(text, *u), file).model_dump(exclude={"units"})
            for u in (("m", 1.0), ("mm", 1e-3))
        )
        if read is shell:
            assert other["mesh"].pop("scale") == 1e-3
            assert other["mesh"].pop("parameters")
            assert one["mesh"].pop("scale") is None
            assert one["mesh"].pop("parameters")
        assert near(one, other)
    part = next((ROOT / "cases").rglob("*.step"))
    text = SOLID.replace("{part}", str(part.relative_to(ROOT)))
    one, other = (
        solid_table(in_unit(text, *u), file)[0].model_dump(exclude={"units"})
        for u in (("m", 1.0), ("mm", 1e-3))
    )
    assert near(one, other)
    _, with_size = solid_table(in_unit(text, "mm", 1e-3), file, size=0.01)
    assert with_size["mesh"]["size"] == pytest.approx(0.01)
