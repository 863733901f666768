"""Turbine files by chance: YAML of any nesting, aliases and tags, and blades of odd numbers."""

import random
from pathlib import Path

import pytest
import yaml
from harness.hostile_changes import changed, places
from harness.hostile_profile import LIMIT_S, count, limited, tries
from samples.blade_samples import blade_table, write_blade

from plymotion.solver.__main__ import main

SCALARS = [
    *("1", "-0", "1e308", "1e999", "9" * 400, "0x" + "f" * 400, "0o7", "1:2:3", "1_0", ".nan"),
    *(".inf", "~", "yes", "''", "'a'", '"\\x00"', '"\\ud800"', "2026-11-22", "2026-99-99"),
    *("!!float x", "!!int ''", "!!binary '='", "!!timestamp a", "!!set {a}", "!!omap [a]", "!x y"),
    *("!!python/object/apply:os.system ['touch P']", "!!python/name:os.system ''", "*no", "%TAG"),
    *("!!python/object/new:subprocess.Popen [[touch, P]]", "? a", "a: b: c", "@", "\t", "\x00"),
]


def _document(chance: random.Random, level: int) -> str:
    """Flow or block of lists, tables, anchors, merges; some of it is no YAML."""
    if level == 0:
        return chance.choice(SCALARS)
    part = _document(chance, level - 1)
    other = _document(chance, min(level - 1, 2))
    deep = chance.choice([2, 99, 101, 100_000])
    return chance.choice(
        [
            f"[{part}, {other}]",
            f"{{a: {part}, b: {other}}}",
            f"{{a: {part}, a: {other}}}",
            f"{{[{part}]: {other}}}",
            f"[&x {part}, *x, *x, &x {other}, *x]",
            f"{{a: &x {{b: {part}}}, c: {{<<: *x, <<: [*x, *x]}}}}",
            f"&x [{part}, *x]",
            "[" * deep + part + "]" * deep,
            "{a: " * deep + part + "}" * deep,
            f"- {part}\n- {other}",
            f"a: {part}\nb: {other}",
            f"--- {part}\n--- {other}",
            "[&a0 [x, x], "
            + ", ".join(f"&a{i + 1} [*a{i}, *a{i}]" for i in range(deep % 97))
            + "]",
        ]
    )


def _ended(file: Path, capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    with limited(LIMIT_S):
        words = ["blade", str(file), "--at", "0.5", "--check", "--out", str(file.parent / "out")]
        code = main([*words, "--quiet"])
    told = capsys.readouterr()
    shown = told.out + told.err
    if code == 70 or "Traceback" in shown:
        return "traceback", shown
    if list(file.parent.rglob("P")):
        return "command run", shown
    if code == 2 and file.name in shown:
        return "refused", shown
    return ("done" if code == 0 else "other"), shown


@pytest.mark.parametrize("block", range(tries(1, 3)))
def test_generated_yaml(tmp_path, monkeypatch, capsys, block):
    """Alone, or as a value in the file of a blade."""
    monkeypatch.chdir(tmp_path)
    chance = random.Random(block)
    whole = yaml.safe_dump(blade_table()).splitlines()
    file = tmp_path / "small.yaml"
    for _ in range(tries(25, 100)):
        text = _document(chance, chance.randrange(6))
        if chance.random() < 0.3:
            lines, k = list(whole), chance.randrange(len(whole))
            lines[k] = f"{lines[k].partition(':')[0]}: {text}"
            text = "\n".join(lines)
        file.write_text(text, "utf-8")
        end, shown = _ended(file, capsys)
        assert end in ("done", "refused"), (end, text[:2000], shown)
        count("blade: a generated YAML file", end)


@pytest.mark.parametrize("block", range(tries(1, 3)))
def test_changed_blades(tmp_path, monkeypatch, capsys, block):
    """One value of a file that is right, coordinates of airfoils rarely."""
    monkeypatch.chdir(tmp_path)
    chance = random.Random(10 + block)
    whole = blade_table()
    every = places(whole)
    ways = [way for way in every if "coordinates" not in way[:-1]]
    ways += chance.sample([way for way in every if way not in ways], 20)
    failures = []
    for _ in range(tries(10, 100)):
        table, kind = changed(chance, whole, ways)
        file = write_blade(tmp_path, table)
        end, shown = _ended(file, capsys)
        if end not in ("done", "refused"):
            failures.append((end, kind, file.read_text("utf-8")[-3000:], shown))
        count(f"blade: a changed file, {kind}", end)
    assert not failures, failures[:3]
