"""Long work without a progress bar says where it is, first within two seconds."""

import io
import os
import re
import subprocess
import sys
import time

import pytest
from harness.hostile_profile import LONG, WAIT_S
from samples.case_samples import HEAD, SOLVER, rigid
from tqdm import tqdm

from plymotion.solver.commands import heartbeat
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run import timing
from plymotion.solver.run.execution import execute, read_run


def test_a_line_for_what_takes_long(capsys, monkeypatch):
    assert heartbeat.FIRST_S < 2.0
    monkeypatch.setattr(heartbeat, "FIRST_S", 0.01)
    beat = heartbeat.Heartbeat()
    told = ""
    try:
        beat.doing = "two: meshing"
        while told.count("\n") < 2:
            time.sleep(0.01)
            told += capsys.readouterr().err
    finally:
        beat.close()
    assert re.fullmatch(r"((starting|two: meshing), \d+ s\n)+", told)
    assert "two: meshing" in told


def test_a_progress_bar_has_no_lines_within(capsys, monkeypatch):
    monkeypatch.setattr(heartbeat, "FIRST_S", 0.01)
    with tqdm(total=1, file=io.StringIO()):
        beat = heartbeat.Heartbeat()
        time.sleep(0.05)
        beat.close()
    assert capsys.readouterr().err == ""


def test_a_run_without_signals_tells_of_its_checks(tmp_path, monkeypatch, caplog):
    """Those of 10,000 bodies take seconds."""
    monkeypatch.setattr(timing, "FIRST_LINE_S", 0.0)
    text = HEAD + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
    text += SOLVER.format(t_end=0.1, step=0.1, more="")
    (tmp_path / "case.toml").write_text(text)
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    with caplog.at_level("INFO"):
        execute(read_run(tmp_path / "build/runs/base.json"), progress=True)
    assert any("signals and reactions: 50 %" in record.message for record in caplog.records)


@pytest.mark.skipif(LONG == 1, reason="starts FEniCSx: `make attack`")
def test_a_thousand_plies(repository, tmp_path, fenicsx):
    text = (repository / "cases/sections/box-layup-1.toml").read_text()
    text = text.replace("ply_thickness = 0.000127", "ply_thickness = 7.62e-7")
    file = tmp_path / "plies.toml"
    file.write_text(text.replace("repeat = 6", "repeat = 1000"))
    process = subprocess.Popen(
        [sys.executable, "-m", "plymotion", "section", str(file), "--out", str(tmp_path)],
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"FENICSX_PYTHON": fenicsx},
    )
    try:
        assert re.match(r"plies: .*, \d+ s|starting, \d+ s", process.stderr.readline())
    finally:
        process.terminate()
        process.communicate(timeout=WAIT_S)
    assert process.returncode == 143
    assert not list(tmp_path.rglob("*.vtkhdf"))
