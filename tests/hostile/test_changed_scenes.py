"""Robots, tables of rotors, units, states and studies by chance: an end in words, 0 or 2."""

import copy
import random
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
from harness.hostile_changes import EXTREMES, SCALES, TEXTS, changed, places, toml_file
from harness.hostile_profile import LIMIT_S, Hang, count, limited, tries
from samples.rotor_samples import write_rotor

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import checked_case
from plymotion.solver.inputs.common.units import LENGTHS

ROBOTS = sorted((Path(__file__).parents[1] / "samples/robots").glob("*.urdf"))
ROBOTS += [Path(__file__).parents[2] / "cases/robot-import/arm.urdf"]
ASKED_S = 1.0  # CPU time of a run after which it gets TERM: many tiny steps are no hang
STOPPED = 143
Found = list[tuple[str, ...]]
Capture = pytest.CaptureFixture[str]


def ended(words: list[str], named: str, capfd: Capture) -> tuple[str, str]:
    """Run a command; return how it ended, and its words, which contain `named` if it refused."""
    capfd.readouterr()
    try:
        with limited(ASKED_S if words[0] == "run" else LIMIT_S):
            code = main(words)
    except Hang:
        return "hang", ""
    except SystemExit as error:
        code = int(error.code or 0)
    told = capfd.readouterr()
    shown = told.out + told.err
    if code == 70 or "Traceback" in shown:
        return "traceback", shown
    if code == 2 and named in shown:
        return "refused", shown
    return ("done" if code in (0, STOPPED) else "other"), f"{code}: {shown}"


def hostile(chance: random.Random, word: str) -> str:
    """Return another word, or one of its numbers scaled."""
    numbers = word.split()
    if numbers and chance.random() < 0.6:
        k = chance.randrange(len(numbers))
        try:
            numbers[k] = repr(float(numbers[k]) * chance.choice([*SCALES, -1.0, 0.0, 1e300]))
        except ValueError:
            numbers[k] = chance.choice(TEXTS)
        return " ".join(numbers)
    return chance.choice([*TEXTS, *map(str, EXTREMES), "nan nan nan", "inf 0 0", "1 2", "1e999"])


def change_robot(chance: random.Random, root: ET.Element) -> str:
    """Change one element of a robot; return how."""
    parent = chance.choice([each for each in root.iter() if len(each)])
    child = chance.choice(list(parent))
    kind = chance.choice(["delete", "repeat", "rename", "text", "value", "value", "value"])
    if kind == "delete":
        parent.remove(child)
    elif kind == "repeat":
        parent.append(copy.deepcopy(child))
    elif kind == "rename":
        child.tag = chance.choice(["link", "joint", "origin", "limit", "mimic", "x", "inertial"])
    elif kind == "text" or not child.attrib:
        child.text = chance.choice(TEXTS)
    else:
        key = chance.choice(list(child.attrib))
        child.attrib[key] = hostile(chance, child.attrib[key])
    return kind


@pytest.mark.parametrize("block", range(tries(1, 4)))
def test_changed_robots(tmp_path: Path, capfd: Capture, block: int) -> None:
    """What is imported is a case that `check` takes."""
    chance, failures = random.Random(block), Found()
    for number in range(tries(15, 100)):
        root = ET.fromstring(chance.choice(ROBOTS).read_text("utf-8"))
        kind = change_robot(chance, root)
        text = ET.tostring(root, "unicode")
        if chance.random() < 0.1:
            kind, text = "cut", text[: chance.randrange(len(text))]
        file, out = tmp_path / "robot.urdf", tmp_path / f"out{number}"
        file.write_text(text, "utf-8")
        joints = chance.choice(["hold", "motor", "free"])
        more = chance.choice([[], ["--keep-fixed"], ["--base", "free"], ["--allow", "units"]])
        words = ["import", str(file), "--no-meshes", "--joints", joints, *more, "--out", str(out)]
        end, shown = ended([*words, "--quiet"], file.name, capfd)
        if end == "refused" and out.exists():
            end = "file lost"
        if end == "done":
            end, shown = ended(["check", str(out / "case.toml")], "no refusal", capfd)
        count(f"import: a changed URDF, {kind}", end)
        if end not in ("done", "refused"):
            failures.append((end, kind, " ".join(words), shown, text))
    assert not failures, (len(failures), failures[:3])


@pytest.mark.parametrize("block", range(tries(1, 4)))
def test_changed_tables_of_a_rotor(tmp_path: Path, capfd: Capture, block: int) -> None:
    """A cell, a row or a character of aero.csv, polars.csv and wind.csv."""
    chance, failures = random.Random(block), Found()
    case = write_rotor(tmp_path, 'file = "wind.csv"')
    (tmp_path / "wind.csv").write_text("time,speed,direction\n0,8,0\n0.5,9,1\n2,9,2\n")
    whole = {file: file.read_text() for file in sorted(tmp_path.glob("*.csv"))}
    for _ in range(tries(15, 100)):
        file, text = chance.choice(list(whole.items()))
        rows = [line.split(",") for line in text.splitlines()]
        k, kind = chance.randrange(len(rows)), chance.choice(["delete", "repeat", "cell", "cell"])
        if kind == "delete":
            del rows[k]
        elif kind == "repeat":
            rows.insert(chance.randrange(len(rows)), rows[k])
        else:
            column = chance.randrange(len(rows[k]))
            rows[k][column] = hostile(chance, rows[k][column])
        text = "\n".join(map(",".join, rows))
        if chance.random() < 0.1:
            kind, text = "cut", text[: chance.randrange(len(text))]
        file.write_text(text, "utf-8")
        end, shown = ended(["check", str(case), "--out", str(tmp_path / "out")], "rotor", capfd)
        if end == "done":
            run = ["run", str(tmp_path / "out/runs/all.json"), "--quiet"]
            end, shown = ended(run, "rotor", capfd) if chance.random() < 0.3 else (end, shown)
        count(f"check, run: a changed table of a rotor, {kind}", end)
        if end not in ("done", "refused"):
            failures.append((end, kind, file.name, str(rows[min(k, len(rows) - 1)]), shown))
        file.write_text(whole[file])
    assert not failures, (len(failures), failures[:3])


SCENE = """
format = 1
title = "a ball, a rail, a state, a study"
gravity = [0.0, 0.0, -9.81]
parameters = { w = 3.0, half = 0.05 }
[bodies.ball]
kind = "rigid"
mass = 2.0
inertia = [[8e-3, 0.0, 0.0], [0.0, 8e-3, 0.0], [0.0, 0.0, 8e-3]]
position = [0.0, 0.0, 0.6]
interfaces = { c = { position = [0.0, 0.0, 0.0] } }
[ground.floor]
position = [0.0, 0.0, 0.0]
[ground.rail]
position = [0.0, 0.0, 0.6]
[joints.rail]
kind = "prismatic"
between = ["ground.rail", "ball.c"]
axis = [0.0, 0.0, 1.0]
start = 0.01
[forces.touch]
kind = "contact"
between = ["ground.floor", "ball.c"]
axis = [0.0, 0.0, 1.0]
radius = "2*half"
stiffness = 1e7
restitution = 0.8
coefficient = 0.3
[forces.guide]
kind = "friction"
joint = "rail"
coefficient = 0.1
length = 0.2
rest_velocity = 0.01
[forces.stop]
kind = "limit_stop"
joint = "rail"
lower = -0.55
upper = 0.2
stiffness = 1e6
[forces.spring]
kind = "nonlinear_spring"
joint = "rail"
length = 0.4
force_displacement = { x = [-0.1, 0.2], y = [-10.0, 20.0], interpolation = "linear" }
[states.slow]
rate = "w * (sin(2*t) - state('fast'))"
start = "w/3"
[states.fast]
rate = "clip(state('slow') - state('fast'), -9, 9) + 0.1*joint_rate('rail')"
size = 2.0
[forces.motor]
kind = "controller"
joint = "rail"
setpoint = "0.1*state('slow')"
proportional = 10.0
upper = 4.0
[signals.z]
kind = "position"
at = "ball.c"
component = "z"
[solver]
t_end = 0.02
output_step = 0.01
[runs.base]
[design.parameters.m]
of = ["bodies.ball.mass"]
kind = "number"
bounds = [0.5, 3.0]
[design.studies.light]
run = "base"
minimise = { mass = "mechanism" }
subject_to = [{ signal = "z", of = "max", max = 1.5, from = 0.001 }]
starts = 1
"""


@pytest.mark.parametrize("block", range(tries(1, 6)))
def test_changed_scenes(tmp_path: Path, capfd: Capture, block: int) -> None:
    """Contact, friction, states, controller and study; a run where `check` takes it."""
    chance, failures, whole = random.Random(block), Found(), tomllib.loads(SCENE)
    ways = [way for way in places(whole) if way != ("units",)]
    for _ in range(tries(20, 100)):
        table, kind = changed(chance, whole, ways)
        (tmp_path / "case.toml").write_text(toml_file(table), "utf-8")
        words = ["check", str(tmp_path / "case.toml"), "--out", str(tmp_path / "out")]
        end, shown = ended(words, "case.toml: ", capfd)
        if end == "done" and chance.random() < 0.2:
            run = ["run", str(tmp_path / "out/runs/base.json"), "--quiet"]
            with pytest.MonkeyPatch.context() as patch:
                patch.chdir(tmp_path)
                end, shown = ended(run, "base.json", capfd)
            end = "done" if shown.startswith("3: ") else end
        count(f"check, run: a changed scene, {kind}", end)
        if end not in ("done", "refused"):
            failures.append((end, kind, shown, toml_file(table)))
    assert not failures, (len(failures), failures[:3])


def other_unit(value: Any, metres: float) -> Any:
    """Return lengths of SCENE in another unit; radius is a text of a parameter."""
    found = copy.deepcopy(value)
    for way in (
        *(("bodies", "ball", "position", i) for i in range(3)),
        *(("ground", name, "position", i) for name in ("floor", "rail") for i in range(3)),
        *(("forces", "stop", key) for key in ("lower", "upper")),
        *(("forces", "spring", "force_displacement", "x", i) for i in range(2)),
        ("forces", "guide", "length"),
        ("forces", "spring", "length"),
        ("joints", "rail", "start"),
        ("parameters", "half"),
    ):
        here = found
        for key in way[:-1]:
            here = here[key]
        here[way[-1]] /= metres
    return found


@pytest.mark.parametrize("block", range(tries(1, 3)))
def test_a_unit_changes_nothing(tmp_path: Path, block: int) -> None:
    """Other numbers, in metres and in another unit: one mechanism, or two refusals."""
    chance, whole = random.Random(block), tomllib.loads(SCENE)
    for _ in range(tries(10, 100)):
        table = copy.deepcopy(whole)
        for key in ("lower", "upper"):
            table["forces"]["stop"][key] *= chance.choice([-1.0, 0.5, 1e3, 1.0])
        table["forces"]["guide"]["length"] *= chance.choice([-1.0, 0.0, 0.3, 1e3, 1.0])
        table["joints"]["rail"]["start"] *= chance.choice([-1.0, 1e9, 3.0])
        table["forces"]["motor"]["upper"] *= chance.choice([1.0, 7.0])
        unit = chance.choice(["cm", "mm", "in"])
        ends = []
        for each in (table, {"units": unit, **other_unit(table, LENGTHS[unit])}):
            try:
                run = checked_case(each, tmp_path / "case.toml").runs["base"]
                ends.append(run.model_dump(exclude={"parameters"}))
            except InputError as error:
                ends.append(str(error).count("\n"))
        one, two = ends
        same = one == pytest.approx(two) if isinstance(one, int) else near(one, two)
        count("check: a case in another unit of length", "refused" if isinstance(one, int) else
              "done" if same else "silent change")  # fmt: skip
        assert same, (unit, one, two)


def near(one: object, two: object) -> bool:
    """Whether plain data agree, numbers to rounding."""
    if isinstance(one, dict) and isinstance(two, dict):
        return one.keys() == two.keys() and all(near(one[k], two[k]) for k in one)
    if isinstance(one, list) and isinstance(two, list):
        return len(one) == len(two) and all(map(near, one, two))
    return one == pytest.approx(two, rel=1e-12) if isinstance(one, float) else one == two


WORDS = ["state('a')", "state('b')", "state('c')", "t", "w", "joint('rail')", "joint_rate('rail')"]
WORDS += ["velocity('ball.c', 'z')", "signal('z')", "1e308", "-1"]
FORMS = [
    "({0}) + {1}",
    "{0} * ({1})",
    "clip({0}, {1}, 9)",
    "sqrt(abs({0}))",
    "step({0})",
    "tanh({0})",
]
FORMS += ["({0}) / ({1})", "({0} if {1} < 1 else t)", "hypot({0}, {1})"]
WRONG = ["state({0})", "{0} {1}", "rate({0})", "state(a)", "state('a", "x", "({0}", "log(-1)"]


def nested(chance: random.Random, level: int) -> str:
    """An expression that reads states and motion, of any depth; some are wrong."""
    if level == 0:
        return chance.choice(WORDS)
    one, two = nested(chance, level - 1), nested(chance, min(level - 1, 2))
    return chance.choice(WRONG if chance.random() < 0.02 else FORMS).format(one, two)


@pytest.mark.parametrize("block", range(tries(1, 4)))
def test_generated_rates_of_states(tmp_path: Path, capfd: Capture, block: int) -> None:
    """Three states that read each other: refused by name, or integrated to an end."""
    chance, failures, whole = random.Random(block), Found(), tomllib.loads(SCENE)
    del whole["design"]
    for _ in range(tries(20, 100)):
        whole["states"] = {
            name: {"rate": nested(chance, chance.randrange(5))[:2500], "start": 0.1}
            for name in "abc"
        }
        whole["forces"]["motor"]["setpoint"] = "state('a') - state('c')"
        (tmp_path / "case.toml").write_text(toml_file(whole), "utf-8")
        words = ["check", str(tmp_path / "case.toml"), "--out", str(tmp_path / "out")]
        end, shown = ended(words, "states.", capfd)
        if end == "done" and chance.random() < 0.2:
            run = ["run", str(tmp_path / "out/runs/base.json"), "--quiet"]
            end, shown = ended(run, "base.json", capfd)
            end = "done" if shown.startswith("3: ") else end
        count("check, run: generated rates of states", end)
        if end not in ("done", "refused"):
            failures.append((end, shown, str(whole["states"])))
    assert not failures, (len(failures), failures[:3])
