"""Changed case files and extreme numbers: an end in time, in words, with an exit code of 0, 2 or 3.

`make attack` tries more and writes the counts to docs/security.md (hostile_profile.py).
"""

import copy
import os
import time
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hostile_profile import count, tries
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from plymotion.solver.__main__ import main

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = {
    "check": sorted(ROOT.glob("cases/*/case.toml")),
    "section": sorted(ROOT.glob("cases/sections/*.toml")),
    "shell": sorted(ROOT.glob("cases/shells/*.toml")),
}
EXTREMES = [0, -1, 1e308, -1e308, 5e-324, 10**30, -(2**63), True, False]
TEXTS = [
    "", " ", "$(shell touch P)", "`touch P`", "a#b", "a:b", "a%b", "two words", "a\nb", "a\x00b",
    "\u00e9", "../../../../etc/passwd", "/dev/zero", "/", "x" * 5000, "$\\foo{$", "1.0", "nan",
]  # fmt: skip
VALUES = st.sampled_from(EXTREMES) | st.sampled_from(TEXTS)
VALUES |= st.sampled_from([[], {}, [[]], [1.0], {"a": 1}, [1.0] * 1000])
LIMIT_S = 60.0  # of one try; the machine may be busy


def _places(table: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = table.items() if isinstance(table, dict) else enumerate(table)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += _places(value, (*path, key))
    return found


def _toml(value: Any) -> str:
    """One value as TOML, tables inline."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return _text(value) if isinstance(value, str) else repr(value)


def _text(word: str) -> str:
    safe = (c if c.isprintable() and c not in '"\\' else f"\\u{ord(c):04x}" for c in word)
    return '"' + "".join(safe) + '"'


def _mutated(data: st.DataObject, table: dict[str, Any]) -> str:
    """Change one place: delete, rename, another value. Return its first key."""
    *way, last = data.draw(st.sampled_from(_places(table)))
    here: Any = table
    for key in way:
        here = here[key]
    kind = data.draw(st.sampled_from(["delete", "rename", "value"]))
    if kind == "delete":
        del here[last]
    elif kind == "rename" and isinstance(here, dict):
        here[data.draw(st.sampled_from(TEXTS[1:]))] = here.pop(last)
    else:
        here[last] = data.draw(VALUES)
    return kind


def _tried(words: list[str], capfd: pytest.CaptureFixture[str]) -> tuple[int, str]:
    capfd.readouterr()
    begin = time.process_time()
    try:
        code = main(words)
    except SystemExit as error:
        code = int(error.code or 0)
    told = capfd.readouterr()
    shown = told.out + told.err
    assert code in (0, 2, 3), shown
    assert "Traceback" not in shown
    assert time.process_time() - begin < LIMIT_S
    return code, shown


@pytest.mark.parametrize("command", SHIPPED)
def test_changed_files(command, tmp_path, capfd, monkeypatch):
    """Errors name the file; what was written before stays as it was."""
    monkeypatch.chdir(tmp_path)
    sources = {file: tomllib.loads(file.read_text("utf-8")) for file in SHIPPED[command]}

    @seed(1)
    @settings(
        max_examples=tries(25, 600),
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(data=st.data())
    def attack(data):
        source = data.draw(st.sampled_from(list(sources)))
        table = copy.deepcopy(sources[source])
        kind = _mutated(data, table)
        # Beside the original, where its relative paths lead to the same files.
        folder = source.parent / f".attack-{os.getpid()}" if command == "none" else tmp_path
        file = folder / "case.toml"
        text = "\n".join(f"{_text(k)} = {_toml(v)}" for k, v in table.items())
        text = text.replace('"../../meshes', f'"{ROOT}/meshes')
        file.write_text(text, encoding="utf-8")
        out = tmp_path / "out"
        before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
        more = ["--check"] if command != "check" else []
        code, shown = _tried([command, str(file), *more, "--out", str(out)], capfd)
        count(f"changed {command} files: {kind}", code)
        if code == 2:
            assert str(file) in shown, shown
            after = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
            assert after == before or command != "check"
        assert not list(tmp_path.rglob("P"))

    attack()


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


def test_extreme_pendulums(tmp_path, capfd):
    """Log-uniform numbers from 5e-324 to 1e308: an end within a limit of steps or time."""
    exponents = st.floats(-323.0, 308.0)
    common = st.floats(-3.0, 3.0)

    @seed(2)
    @settings(
        max_examples=tries(25, 700),
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
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
        code, _ = _tried(words, capfd)
        if code == 0:
            run = ["run", str(tmp_path / "out/runs/base.json"), "--quiet"]
            code, _ = _tried(run, capfd)
        count("pendulums of extreme numbers", code)

    attack()
