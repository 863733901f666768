"""What a run is worth by its findings, in words on the screen and in the exit code."""

import json

import pytest
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.report.table import summary_table
from plymotion.solver.results.summary import invalid_words, verdict

ERROR = {"code": "spin-above-clamped-frequency", "level": "error", "t": 0.25, "message": "-"}
WARNING = {"code": "modes-too-few", "level": "warning", "message": "-"}
NOTE = {"code": "singular-passed", "level": "note", "message": "-"}


@pytest.mark.parametrize(
    ("completed", "found", "expected", "shown"),
    [
        (True, [], "good", "yes"),
        (True, [NOTE], "good", "yes"),
        (True, [NOTE, WARNING], "doubt", "yes"),
        (True, [WARNING, ERROR], "bad", "invalid"),
        (False, [], "bad", "NO"),
    ],
)
def test_verdict(completed, found, expected, shown):
    summary = {"run": "base", "completed": completed, "warnings": found}
    assert verdict(summary) == expected
    assert summary_table([summary]).splitlines()[3].split()[1] == shown
    assert bool(invalid_words(summary)) == (shown == "invalid")


def test_a_run_that_its_findings_call_invalid_is_not_done(repository, tmp_path, capsys):
    """The hand of lay-up 2 spins above its first frequency from the start, and goes on."""
    text = (repository / "cases/double-pendulum-limits/case.toml").read_text()
    file = tmp_path / "case.toml"
    more = '[variants.short.solver]\nt_end = 0.02\n[runs.short]\nvariants = ["layup-2", "soft", '
    more += '"following", "go-on", "short"]\n'
    file.write_text(text + more)
    out = tmp_path / "out"
    words = [str(file), "--run", "short", "--out", str(out), "--no-report"]
    packages = str(repository / "tests/packages/double-pendulum-limits")
    assert main([*words, "--packages", packages]) == 3
    told = capsys.readouterr().out
    assert "short: invalid from t = 0 s (spin-above-clamped-frequency), ended at t = 0.02" in told
    assert json.loads((out / "short/summary.json").read_text())["completed"]
    assert main([*words, "--packages", packages]) == 3  # again, with nothing to do


def test_a_run_without_findings_is_done(tmp_path, capsys):
    file = tmp_path / "case.toml"
    body = rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
    file.write_text(HEAD + body + SOLVER.format(t_end=0.02, step=0.01, more=""))
    assert main([str(file), "--out", str(tmp_path / "out")]) == 0
    assert "base: done at t = 0.02 s" in capsys.readouterr().out
