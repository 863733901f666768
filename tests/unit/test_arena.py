"""The arena's frame: a scene and a code of a stranger, ours measured against a closed form."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ARENA = ROOT / "benchmarks/arena"
OURS = {"segments": [2], "rtols": [1e-6], "cells": [8]}
CODE = """
import os

from common import main

NAME = "Still"
ENVIRONMENT = {"own": True}


def cannot(sheet):
    return "" if sheet["kind"] == "mechanism" else "no mechanism"


def settings(sheet):
    return [{"method": "rest"}]


if __name__ == "__main__":
    assert "PYTHONDONTWRITEBYTECODE" not in os.environ
    assert os.environ["OMP_NUM_THREADS"] == "1"
    main(lambda sheet, setting: ([sheet["probe"]["global"]] * len(sheet["times"]), 1.0))
"""


def stranger(folder: Path, **changes: str) -> Path:
    """A folder of scenes with the pendulum for a tenth of a second, only by radau."""
    own = folder / "scenes/my-pendulum"
    own.mkdir(parents=True)
    source = ARENA / "scenes/pendulum"
    for name in ("case.toml", "scene.py"):
        (own / name).write_text((source / name).read_text())
    text = (source / "scene.toml").read_text().replace("t_end = 10.0", "t_end = 0.1")
    for old, new in changes.items():
        text = text.replace(old, new)
    (own / "scene.toml").write_text('ours = { methods = ["gear"] }\n' + text)
    return own.parent


def arena(folder: Path, scenes: Path, *more: str) -> subprocess.CompletedProcess[str]:
    """Run the command in a folder of its own."""
    command = [sys.executable, str(ARENA / "arena.py"), "--no-install", "--scenes", str(scenes)]
    command += ["--out", str(folder / "out"), *more, "my-pendulum"]
    caller = os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "2"}
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False, env=caller
    )


def test_a_stranger_adds_a_scene_and_a_code(tmp_path: Path) -> None:
    """Both are found; the error of each is that against the closed form."""
    runners = tmp_path / "runners"
    runners.mkdir()
    (runners / "in_still.py").write_text(CODE)
    done = arena(
        tmp_path, stranger(tmp_path), "--runners", str(runners), "--codes", "plymotion,still"
    )
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "out/arena.json").read_text())
    assert found["scenes"] == 1
    assert found["truths"] == {"my-pendulum": 1e-12}
    rows = {row["code"]: row for row in found["trials"]}
    assert set(rows) == {"Plymotion", "Still"}
    assert rows["Plymotion"]["failed"] == ""
    assert 1e-10 < rows["Plymotion"]["error"] < 1e-3
    # the tip falls by half of 3/2 g t^2 at first, so that a body at rest is wrong by that
    assert rows["Still"]["error"] == pytest.approx(0.75 * 9.81 * 0.1**2, rel=0.01)
    assert 0.0 < rows["Plymotion"]["solution_s"] < rows["Plymotion"]["process_s"]
    assert "my-pendulum, solution" in found["won"] | found["lost"]
    assert "my-pendulum.svg" in (tmp_path / "out/index.html").read_text()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('kind = "mechanism"', 'kind = "mechanics"', "kind = 'mechanics': expected one of"),
        ("probe =", "prob =", "probe: missing, expected in a mechanism"),
        ("quick =", "quickly =", "quickly: unknown; a mechanism may have"),
    ],
)
def test_a_wrong_key_is_named(tmp_path: Path, old: str, new: str, told: str) -> None:
    """File, key and what was expected."""
    sys.path.insert(0, str(ARENA))
    try:
        import scenes

        place = stranger(tmp_path, **{old: new})
        with pytest.raises(SystemExit, match=r"scene\.toml") as error:
            scenes.find([place])
    finally:
        sys.path.remove(str(ARENA))
    assert told in str(error.value)


def test_every_code_is_listed_or_says_why_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """All runners; each has settings for a scene of its own, and a reason for one of another."""
    monkeypatch.syspath_prepend(str(ARENA))
    import frame

    scenes = {
        "beam": {"kind": "mechanism", "beam": {"static": True}, "joints": [], "times": [0.1]},
        "shell": {"kind": "shell", "file": str(ROOT / "cases/shells/scordelis-lo.toml")},
    }
    able = {name: set[str]() for name in scenes}
    for runner in frame.runners(False):
        assert runner.version or runner.absent
        for name, sheet in scenes.items():
            why = runner.module.cannot(sheet)
            if not why:
                assert all("method" in s for s in runner.module.settings(sheet | {"ours": OURS}))
                able[name].add(runner.name)
    assert able["beam"] == {"Exudyn", "Kratos", "Plymotion", "SHARPy"}
    assert able["shell"] == {"CalculiX", "Kratos", "MYSTRAN", "Plymotion"}
