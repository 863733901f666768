"""`mpirun -n N plymotion section`: the ranks share each analysis, the first writes and shows it."""

import json
import os
import subprocess
import sys
from pathlib import Path
from shutil import which

import numpy as np
import pytest
from harness.mpi_samples import OPEN_MPI

from plymotion.solver.report.section.codes import read_results
from plymotion.solver.workers import launch

SECTION = """format = 1
title = "Tube"
[mesh]
shape = "box"
width = 0.05
height = 0.03
wall = 0.002
[materials.aluminium]
kind = "isotropic"
E = 70e9
nu = 0.3
rho = 2700.0
[laminates.wall]
plies = [{ material = "aluminium", thickness = 0.002, angle_deg = 0.0 }]
[regions.all]
laminate = "wall"
"""


@pytest.fixture
def section(tmp_path: Path) -> Path:
    (tmp_path / "tube.toml").write_text(SECTION)
    return tmp_path / "tube.toml"


def plymotion(section: Path, python: str, *words: str, ranks: int = 1) -> tuple[int, str, str]:
    """Exit code and output of `plymotion section`, on some ranks."""
    own = Path(python).parent / "mpiexec"  # of the wheel, whose MPI it must be
    launcher = str(own) if own.exists() and own.parent != Path("/usr/bin") else which("mpirun")
    if launcher is None:
        pytest.skip("no mpirun here")
    start = [launcher, "-n", str(ranks)] if ranks > 1 else []
    done = subprocess.run(
        [*start, sys.executable, "-m", "plymotion", "section", str(section), "--quiet", *words],
        cwd=section.parent,
        env={**os.environ, **OPEN_MPI, "FENICSX_PYTHON": python},
        capture_output=True,
        text=True,
        timeout=120,
    )
    return done.returncode, done.stdout, done.stderr


def test_ranks_share_a_section(section: Path, fenicsx: str) -> None:
    words = ("--json", "--no-figures")
    code, told, errors = plymotion(section, fenicsx, *words, "--out", "one")
    assert code == 0, errors
    code, shared, errors = plymotion(section, fenicsx, *words, "--out", "two", ranks=2)
    assert code == 0, errors
    assert json.loads(shared)["K"] == pytest.approx(
        np.array(json.loads(told)["K"]), rel=1e-9, abs=1
    )
    (file,) = (section.parent / "two").glob("**/*.vtkhdf")
    assert read_results(file).provenance["ranks"] == 2
    code, again, errors = plymotion(section, fenicsx, "--out", "two", "--no-figures", ranks=2)
    assert (code, "(unchanged)" in again) == (0, True), errors


def test_a_wrong_description_is_said_once(section: Path, fenicsx: str) -> None:
    section.write_text(SECTION.replace("wall = 0.002", "wall = 0.2"))
    code, told, errors = plymotion(section, fenicsx, "--out", "bad", ranks=2)
    assert (code, told) == (2, "")
    assert errors.count("error: ") == 1, errors
    assert not list(section.parent.glob("bad/**/*.vtkhdf"))


def test_jobs_and_ranks_exclude_each_other(section: Path, fenicsx: str) -> None:
    code, _, errors = plymotion(section, fenicsx, "--jobs", "2", ranks=2)
    assert code == 2
    assert "--jobs 2: expected without mpirun" in errors


def test_a_job_is_recognised(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in {name for pair in launch.JOB for name in pair}:
        monkeypatch.delenv(name, raising=False)
    assert launch.mpi_job() == (0, 1)
    monkeypatch.setenv("PMI_RANK", "1")
    monkeypatch.setenv("PMI_SIZE", "4")
    assert launch.mpi_job() == (1, 4)
