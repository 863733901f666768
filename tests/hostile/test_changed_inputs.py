"""Changed inputs and extreme numbers: an end in time and in words, with exit code 0, 2 or 3.

`make attack` tries more and writes the counts to docs/attack.md (hostile_profile.py).
"""

import copy
import json
import random
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from harness.hostile_changes import EXTREMES, SCALES, TEXTS, inner, places, toml_file
from harness.hostile_profile import LIMIT_S, Hang, count, limited, tries
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from samples.sweep_samples import BALL, FORCE, ball

from plymotion.solver.__main__ import main
from plymotion.solver.errors import printable

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = {
    "check": sorted(ROOT.glob("cases/*/case.toml")),
    "section": sorted(ROOT.glob("cases/sections/*.toml")),
    "shell": sorted(ROOT.glob("cases/shells/*.toml")),
}
BLOCK = 100  # tries of a test: an attack that was interrupted goes on after the last block
BLOCKS = [
    (command, block)
    for command, blocks in (("check", 9), ("section", 5), ("shell", 5))
    for block in range(tries(1, blocks))
]
VALUES = st.sampled_from(EXTREMES) | st.sampled_from(TEXTS)
VALUES |= st.sampled_from([[], {}, [[]], [1.0], {"a": 1}, [1.0] * 1000])
ASKED_S = 1.0  # CPU time of a run after which it gets TERM: 1e12 steps are no hang
SETTINGS: dict[str, Any] = {
    "deadline": None,
    "database": None,
    "phases": [Phase.generate],
    "suppress_health_check": list(HealthCheck),
}


def _mutated(data: st.DataObject, table: dict[str, Any]) -> str:
    """Change one place: delete, rename, another value. Return what was done."""
    *way, last = data.draw(st.sampled_from(places(table)))
    here = inner(table, way)
    kind = str(data.draw(st.sampled_from(["delete", "rename", "value", "number"])))
    if kind == "rename" and isinstance(here, dict):
        here[data.draw(st.sampled_from(TEXTS[1:]))] = here.pop(last)
    elif kind == "delete":
        del here[last]
    elif kind == "number" and isinstance(here[last], float):
        here[last] *= data.draw(st.sampled_from(SCALES))
    else:
        kind = "value"
        here[last] = data.draw(VALUES)
    return kind


def _named_keys(table: dict[str, Any]) -> set[str]:
    """Keys that a message may begin with: of the file, of a mechanism with a variant."""
    variants = table.get("variants")
    parts = [table, table.get("coarse"), *(variants.values() if isinstance(variants, dict) else [])]
    return {key for part in parts if isinstance(part, dict) for key in part}


def _ended(words: list[str], capfd: pytest.CaptureFixture[str]) -> tuple[str, str]:
    """Run a command; return how it ended, and its words."""
    capfd.readouterr()
    try:
        with limited(ASKED_S if words[0] == "run" else LIMIT_S):
            code: Any = main(words)
    except SystemExit as error:
        code = error.code or 0
    except Hang:
        return "hang", ""
    told = capfd.readouterr()
    shown = told.out + told.err
    if "Traceback" in shown or code == 70:
        return "traceback", shown
    ends = {0: "done", 2: "refused", 3: "refused", 143: "done" if words[0] == "run" else "other"}
    return ends.get(code, "other"), f"{code}: {shown}"


def _told(failures: list[tuple[str, ...]]) -> None:
    """Fail with all that was found: one long attack finds more than one defect."""
    for failure in failures:
        print("\n".join(["", "-" * 80, *failure]))
    assert not failures, f"{len(failures)} tries ended badly"


def _content(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(("command", "block"), BLOCKS)
def test_changed_files(command, block, tmp_path, capfd, monkeypatch):
    """Errors name file and key; what was written before stays as it was."""
    monkeypatch.chdir(tmp_path)
    # Beside the originals: relative paths in them lead to the same files.
    shutil.copytree(ROOT / "cases", tmp_path / "cases")
    (tmp_path / "meshes").symlink_to(ROOT / "meshes")
    sources = {file: tomllib.loads(file.read_text("utf-8")) for file in SHIPPED[command]}
    out = tmp_path / "out"
    more = ["--check"] if command != "check" else []

    @seed(1 + 1000 * block)
    @settings(max_examples=tries(12, BLOCK), **SETTINGS)
    @given(data=st.data())
    def attack(data):
        source = data.draw(st.sampled_from(list(sources)))
        table = copy.deepcopy(sources[source])
        kind = _mutated(data, table)
        text = toml_file(table)
        file = tmp_path / source.relative_to(ROOT).with_name("attacked.toml")
        file.write_text(text, encoding="utf-8")
        before = _content(out)
        end, shown = _ended([command, str(file), *more, "--out", str(out)], capfd)
        if end == "refused" and command == "check" and _content(out) != before:
            end = "file lost"
        if list(tmp_path.rglob("P")):
            end = "command run"
        count(f"{command}: a changed description, {kind}", end)
        keys = _named_keys(sources[source]) | _named_keys(table)
        told = any(f"{file.name}: {printable(key)}" in shown for key in keys)
        if end not in ("done", "refused") or (end == "refused" and not told):
            failures.append((source.name, end, text[:3000], shown))

    failures: list[tuple[str, ...]] = []
    attack()
    _told(failures)


PENDULUM = """
format = 1
title = "extremes"
gravity = [0.0, {gravity}, 0.0]
[bodies.rod]
kind = "rigid"
mass = {mass}
inertia = [[{inertia}, 0.0, 0.0], [0.0, {inertia}, 0.0], [0.0, 0.0, {inertia}]]
centre = [{length}, 0.0, 0.0]
interfaces = {{ end = {{ position = [0.0, 0.0, 0.0] }} }}
[ground.O]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.O", "rod.end"]
axis = [0.0, 0.0, 1.0]
[solver]
t_end = {t_end}
output_step = {step}
[runs.base]
"""


@pytest.mark.parametrize("block", range(tries(1, 2)))
def test_extreme_pendulums(block, tmp_path, capfd):
    """Log-uniform numbers from 5e-324 to 1e308: an end by itself, or at TERM."""
    exponents = st.floats(-323.0, 308.0)
    common = st.floats(-3.0, 3.0)

    @seed(2 + 1000 * block)
    @settings(max_examples=tries(12, BLOCK), **SETTINGS)
    @given(data=st.data())
    def attack(data):
        names = ("mass", "inertia", "length", "gravity")
        odd = data.draw(st.sets(st.sampled_from(names), min_size=1, max_size=2))
        values = {
            name: max(10.0 ** data.draw(exponents if name in odd else common), 5e-324)
            for name in names
        }
        t_end = 1e-3 if "gravity" not in odd else 1e-6
        text = PENDULUM.format(**values, t_end=t_end, step=t_end / 4)
        (tmp_path / "case.toml").write_text(text)
        words = ["check", str(tmp_path / "case.toml"), "--out", str(tmp_path / "out")]
        end, shown = _ended(words, capfd)
        if end == "done":
            run = ["run", str(tmp_path / "out/runs/base.json"), "--quiet"]
            end, shown = _ended(run, capfd)
        count("run: a pendulum of extreme numbers", end)
        if end not in ("done", "refused"):
            failures.append((str(values), end, shown))

    failures: list[tuple[str, ...]] = []
    attack()
    _told(failures)


@pytest.mark.parametrize(
    ("key", "name", "value"), [("length", "centre.0", 1e152), ("mass", "mass", 1.5e-316)]
)
def test_an_overflow_names_the_number(tmp_path, capfd, key, name, value):
    values = {"mass": 1.0, "inertia": 1.0, "length": 1.0, "gravity": 1.0} | {key: value}
    sweep = '[sweeps.s]\nrun = "base"\nvary = { "gravity.0" = [0.0] }\n'
    text = PENDULUM.format(**values, t_end=1e-3, step=1e-3) + sweep
    (tmp_path / "case.toml").write_text(text)
    out = tmp_path / "out"
    assert main(["check", str(tmp_path / "case.toml"), "--out", str(out)]) == 0
    assert main(["run", str(out / "runs/base.json"), "--quiet"]) == 2
    told = f"bodies.rod.{name} = {value:g}: expected numbers whose"
    assert f"{out / 'runs/base.json'}: {told}" in capfd.readouterr().err
    assert main(["sweep", str(out / "sweeps/s.json"), "--quiet", "--no-figures"]) == 3
    assert f"failed [input] gravity.0 = 0: s: {told}" in capfd.readouterr().out


def test_changed_sweep_files(tmp_path, capsys):
    """build/CASE/sweeps/NAME.json: one value deleted, repeated or replaced by another kind."""
    file = ball(tmp_path, f"{FORCE} = [1.0, 2.0]", 'histories = ["x"]')
    whole = json.loads(file.read_text("utf-8"))
    ways = [way for way in places(whole) if way[0] not in ("mechanism", "other_runs")]
    chance = random.Random(2)
    for _ in range(tries(15, 150)):
        table = copy.deepcopy(whole)
        *outer, last = chance.choice(ways)
        here = inner(table, outer)
        kind = chance.choice(["delete", "repeat", "value", "value"])
        if kind == "delete":
            del here[last]
        elif kind == "repeat" and isinstance(here, list):
            here.append(here[last])
        else:
            here[last] = chance.choice([None, [], {}, "", "x", -1, 10**400, 1e308, True, 99])
        file.write_text(json.dumps(table), "utf-8")
        code = main(["sweep", str(file), "--jobs", "1", "--no-figures", "--quiet", "--fresh"])
        told = capsys.readouterr().err
        assert code in (0, 3) or (code == 2 and str(file) in told), (code, told)
        count("sweep: a changed sweep file", "refused" if code == 2 else "done")


POLYNOMIAL = "law = { polynomial = [0.0, 0.0, 0.0, 1.0] }"


def _nested(chance: random.Random, level: int) -> str:
    """An expression of functions in functions, and of long rows of operations."""
    if level == 0:
        return chance.choice(["t", "1", "pi", "2.5", "9" * 400])
    parts = [_nested(chance, level - 1), _nested(chance, min(level - 1, 2))]
    several = chance.choice([2, 30]) if len(parts[0]) < 30 else 1
    return chance.choice(
        [
            f"hypot({parts[0]}, {parts[1]})",
            f"rate({parts[0]})",
            f"({parts[0]} if {parts[1]} < 1 else t)",
            f"sin({parts[0]})",
            f"({parts[0]}) ** ({parts[1]})",
            "<".join(parts[:1] * several),
            f"max({', '.join(parts[:1] * several)})",
            " and ".join(parts[:1] * several),
        ]
    )


@pytest.mark.parametrize("block", range(tries(1, 6)))
def test_generated_expressions(tmp_path, capsys, block):
    """Of any depth: parsed or refused in words and in time."""
    chance = random.Random(block)
    for _ in range(tries(30, 100)):
        text = _nested(chance, chance.randrange(1, 30 if chance.random() < 0.3 else 7))[:2500]
        table = BALL.replace(POLYNOMIAL, f"law = {{ expression = '{text}' }}")
        (tmp_path / "case.toml").write_text(table, "utf-8")
        with limited(LIMIT_S):
            code = main(["check", str(tmp_path / "case.toml")])
        told = capsys.readouterr().err
        assert code == 0 or (code == 2 and "forces.push" in told), (code, told, text)
        count("check: a generated expression", "refused" if code else "done")
