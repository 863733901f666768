"""`plymotion case.toml`: from a case file to its report, in any folder."""

import json
import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.math import disk_cache as digests

CASE = Path("cases/double-pendulum/case.toml").resolve()
PACKAGES = Path("tests/packages/double-pendulum").resolve()
SHORT = """
[variants.short.solver]
t_end = 0.05

[runs.short]
variants = ["short"]
"""


@pytest.fixture
def pendulum(tmp_path, monkeypatch):
    """A copy of a case, short, in a folder of its own, which is the current one."""
    file = tmp_path / "pendulum.toml"
    file.write_text(CASE.read_text(encoding="utf-8") + SHORT, encoding="utf-8")
    packages = tmp_path / "packages"
    packages.mkdir()
    for source in PACKAGES.glob("*.vtkhdf"):
        (packages / source.name).symlink_to(source)
    monkeypatch.chdir(tmp_path)
    return file


def _main(*words):
    return main([str(word) for word in words])


def test_from_case_to_report(pendulum, capsys):
    words = (pendulum.name, "--run", "short", "--packages", "packages")
    assert _main(*words) == 0
    page = Path("build/pendulum/report.html")
    assert page.is_file()
    summary = json.loads(Path("build/pendulum/short/summary.json").read_text())
    assert summary["status"] == "finished"
    assert summary["t_end"] == 0.05
    first = capsys.readouterr()
    assert "short: done at t = 0.05 s" in first.out
    assert "Report: build/pendulum/report.html" in first.out
    assert "runs: 1" in first.err
    # a second time nothing is done again
    before = Path("build/pendulum/short/result.vtkhdf").stat().st_mtime_ns
    assert _main("run", *words, "--quiet") == 0
    again = capsys.readouterr()
    assert again.out == "build/pendulum/report.html: up to date\n"
    assert again.err == ""
    assert Path("build/pendulum/short/result.vtkhdf").stat().st_mtime_ns == before
    assert _main(*words, "--force", "--no-report") == 0
    assert Path("build/pendulum/short/result.vtkhdf").stat().st_mtime_ns > before


def test_another_folder(pendulum):
    words = ("--run", "short", "--packages", "packages", "--no-report", "--out", "there")
    assert _main(pendulum.name, *words) == 0
    assert Path("there/short/summary.json").is_file()
    assert not Path("build").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("pendulum.toml", "--run", "shrt"), "--run shrt: pendulum.toml has no such run; did you"),
        (("nothing.toml",), "nothing.toml: no such case file"),
        (("run", "pendulum.toml", "other.toml"), "expected one case file, or run files only"),
        (("pendulum.toml", "--update"), "--update: for run files"),
        (("run", "runs/short.json", "--force"), "--force: expected with a case file only"),
    ],
)
def test_wrong_arguments(pendulum, capsys, words, message):
    assert _main(*words) == 2
    assert message in capsys.readouterr().err
    assert not Path("build").exists()


def test_name_of_a_case(pendulum, tmp_path):
    folder = tmp_path / "arm"
    folder.mkdir()
    shutil.copy(pendulum, folder / "case.toml")
    words = ("--run", "short", "--packages", "packages", "--no-report")
    assert _main("arm/case.toml", *words) == 0
    assert _main("run", "arm", *words) == 0
    assert [path.name for path in Path("build").iterdir()] == ["arm"]


def test_packages_of_the_own_folder_are_kept(pendulum):
    """Named by --packages, they are read, not removed as no longer wanted."""
    assert _main("check", pendulum.name, "--out", "build/pendulum") == 0
    bodies = Path("build/pendulum/bodies")
    for spec in bodies.glob("*.json"):
        shutil.copy(PACKAGES / f"{spec.stem}.vtkhdf", bodies)
    before = sorted(path.name for path in bodies.iterdir())
    assert _main("check", pendulum.name, "--out", "build/pendulum", "--packages", str(bodies)) == 0
    assert sorted(path.name for path in bodies.iterdir()) == before


def test_a_sweep_in_place_of_runs(pendulum, capsys):
    pendulum.write_text(
        pendulum.read_text(encoding="utf-8")
        + '[sweeps.step]\nrun = "short"\nsignals = ["tip_x"]\n'
        + 'vary = { "solver.output_step" = [0.01, 0.02] }\n',
        encoding="utf-8",
    )
    # In this process: workers of a sweep are tested in tests/cases/test_executors.py.
    more = ("--packages", "packages", "--quiet", "--jobs", "1")
    words = (pendulum.name, "--sweep", "step", *more)
    assert _main(*words) == 0
    folder = Path("build/pendulum")
    assert (folder / "sweeps/step/sweep.csv").is_file()
    assert not (folder / "short").exists()
    assert "step: 2 members, 2 finished" in capsys.readouterr().out
    assert _main(*words) == 0
    assert capsys.readouterr().out == "build/pendulum/sweeps/step: up to date\n"

    # A sweep whose files are made anew leaves a finished run as it is.
    for file in ("manifest.json", "sweeps/step.json", "sweeps/step/sweep.h5"):
        (folder / file).unlink()
    run = (pendulum.name, "--run", "short", "--packages", "packages", "--quiet")
    assert _main(*run) == 0
    assert _main(*words) == 0
    capsys.readouterr()
    assert _main(*run) == 0
    assert capsys.readouterr().out == "build/pendulum/report.html: up to date\n"
    (folder / "manifest.json").unlink()
    assert _main(*run) == 0
    assert (folder / "manifest.json").is_file()
    assert _main(pendulum.name, "--sweep", "stp", "--packages", "packages") == 2
    assert "--sweep stp: pendulum.toml has no such sweep; did you mean 'step'?" in (
        capsys.readouterr().err
    )


def test_what_has_changed_is_done_again(pendulum, capsys):
    """Inputs, results and options; each change leads to the stage that it concerns."""
    words = (pendulum.name, "--run", "short", "--packages", "packages", "--quiet")
    folder = Path("build/pendulum")
    assert _main(*words) == 0
    for file in (folder / "report.html", folder / "short/summary.json", folder / "case.json"):
        file.unlink()
        assert _main(*words) == 0
        assert file.is_file()
    capsys.readouterr()
    text = pendulum.read_text(encoding="utf-8")
    pendulum.write_text(text.replace("t_end = 0.05", "t_end = 0.04"), encoding="utf-8")
    assert _main(*words) == 0
    assert "short: done at t = 0.04 s" in capsys.readouterr().out
    (Path("packages") / "arm.isotropic.vtkhdf").unlink()
    assert _main(*words) == 2  # not "up to date"


def test_two_commands_in_one_folder_take_turns(tmp_path):
    file = tmp_path / "ball.toml"
    ball = rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
    file.write_text(HEAD + ball + SOLVER.format(t_end=0.02, step=0.01, more=""))
    words = [sys.executable, "-m", "plymotion", file.name, "--no-report"]
    here = os.environ | {"PYTHONPATH": str(CASE.parents[2]), "PLYMOTION_COMPILED": "0"}
    pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    both = [subprocess.Popen(words, env=here, cwd=tmp_path, **pipe) for _ in range(2)]
    told = [process.communicate(timeout=300) for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert sorted("base: done" in out for out, _ in told) == [False, True]
    assert sorted("build/ball: up to date" in out for out, _ in told) == [False, True]
    assert sum("waiting for another command" in err for _, err in told) <= 1


def test_a_checkout_is_identified_by_its_sources(tmp_path, monkeypatch):
    """A change of a source beside `plymotion` is another program."""
    for part in ("solver", "preprocess", "meshes"):
        (tmp_path / part).mkdir()
        (tmp_path / part / "one.py").write_text("1")
    monkeypatch.setattr(
        digests, "_ROOT", tmp_path
    )  # solver/math/disk_cache.py is two folders below
    program = partial(digests.sources_sha256.__wrapped__, "solver", "preprocess", "meshes")
    before = program()
    (tmp_path / "solver/one.py").write_text("2")  # of the same size
    assert program() != before
