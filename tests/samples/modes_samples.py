"""Modes of small cases written as text, by the command as a user calls it."""

import json
from pathlib import Path

import pytest
from samples.case_samples import HEAD, SOLVER

from plymotion.solver.__main__ import main


def write_case_text(folder: Path, text: str, more: str = "") -> Path:
    """A case file of one run; `more` are keys of [solver]."""
    file = folder / "sample" / "case.toml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(HEAD + text + SOLVER.format(t_end=1.0, step=0.1, more=more))
    return file


def modes_at(
    folder: Path, text: str, at: str, *options: str, capsys: pytest.CaptureFixture, more: str = ""
) -> dict:
    """Content of modes.json or campbell.json of a case."""
    file = write_case_text(folder, text, more)
    out = folder / "out"
    arguments = ["modes", str(file), "--at", at, "--json", "--shapes", "0", "--out", str(out)]
    assert main([*arguments, *options]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def rates(content: dict) -> list[float]:
    """Angular frequencies above zero, rising."""
    return [m["angular_frequency"] for m in content["modes"] if m["angular_frequency"] > 0.0]
