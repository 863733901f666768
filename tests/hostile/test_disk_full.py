"""A disk without room: the message says how much is missing, and nothing else is lost."""

import subprocess
import sys

import numpy as np
import pytest
from harness.forks import forks
from harness.hostile_profile import count
from samples.package_samples import cantilever
from samples.result_samples import swinging_rod
from samples.sweep_samples import FORCE, ball

from plymotion.solver.__main__ import main
from plymotion.solver.package import write_package
from plymotion.solver.package.common.files import SEAL
from plymotion.solver.results import read_result, write_result

resource = pytest.importorskip("resource")
# Files cannot grow beyond a limit: what a disk without room answers, for one process.
LIMITED = """
import resource, sys
from plymotion.solver.__main__ import main
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
sys.exit(main(sys.argv[2:]))
"""


def _limited(limit, *words):
    return forks.run(LIMITED, str(limit), *map(str, words), PLYMOTION_CACHE="/nonexistent")


@pytest.mark.parametrize("limit", [0, 100, 4096, 9000, 20_000])
def test_a_run_without_room(tmp_path, monkeypatch, limit):
    """Wherever in the file the room ends."""
    # A result keeps the command's words: those of pytest are not those of the other process.
    monkeypatch.setattr(sys, "argv", ["-c"])
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0]")
    run = file.parent.parent / "runs/base.json"
    assert main(["run", str(run), "--quiet"]) == 0
    out = run.parent.parent / "base"
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    done = _limited(limit, "run", run, "--quiet")
    assert done.returncode == 2, done.stderr
    size = len(before["result.vtkhdf"])
    assert f"{out / 'result.vtkhdf'}: File too large; the file needs {size} bytes" in done.stderr
    assert "are free" in done.stderr
    assert done.stderr.count("\n") == 1
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    count("run: a file that may not grow", "refused")


@pytest.mark.parametrize("limit", [100, 9000])
def test_a_sweep_without_room(tmp_path, limit):
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]')
    assert main(["sweep", str(file), "--quiet", "--no-figures"]) == 0
    out = file.with_suffix("")
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    done = _limited(limit, "sweep", file, "--quiet", "--no-figures", "--fresh")
    assert done.returncode == 2, done.stderr
    assert f"{out / 'sweep.h5'}: File too large; the file needs " in done.stderr
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_a_check_without_room(tmp_path):
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0]")
    build = file.parent.parent
    before = {p: p.read_bytes() for p in build.rglob("*") if p.is_file()}
    case = tmp_path / "case.toml"
    case.write_text(case.read_text().replace("t_end = 1.0", "t_end = 2.0"))
    done = _limited(100, "check", case, "--out", build)
    assert done.returncode == 2
    assert "File too large" in done.stderr
    assert {p: p.read_bytes() for p in build.rglob("*") if p.is_file()} == before
    assert main(["check", str(case), "--out", str(build)]) == 0
    count("check: a file that may not grow", "refused")


def test_a_file_that_is_written_through_is_the_same(tmp_path):
    """Sizes of every kind; the seal is the last line."""
    result = swinging_rod()
    write_result(tmp_path / "r.vtkhdf", result)
    raw = (tmp_path / "r.vtkhdf").read_bytes()
    assert SEAL in raw[-100:]
    assert np.array_equal(read_result(tmp_path / "r.vtkhdf").q, result.q)
    write_result(tmp_path / "s.vtkhdf", result)
    assert (tmp_path / "s.vtkhdf").read_bytes() == raw


def test_files_of_killed_processes_go(tmp_path):
    """The next writer of a folder removes them, and no others."""
    code = (
        "import os, sys, signal; from pathlib import Path\n"
        "from plymotion.solver.package.common.files import temporary_sibling\n"
        "with temporary_sibling(Path(sys.argv[1])) as file:\n"
        "    file.write_text('half')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    others = [tmp_path / ".mine", tmp_path / f".x.other-{2**22}-0123abcd.json"]
    for file in others:
        file.write_text("kept")
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "a.json")], check=False)
    assert len(list(tmp_path.iterdir())) == 3
    write_result(tmp_path / "r.vtkhdf", swinging_rod())
    assert sorted(tmp_path.iterdir()) == sorted([*others, tmp_path / "r.vtkhdf"])


@pytest.mark.parametrize("limit", [100, 3000])
def test_an_export_without_room(tmp_path, limit):
    """A MED file is an HDF5 file, whose library does not survive an error of the disk."""
    package, out = tmp_path / "arm.vtkhdf", tmp_path / "arm.med"
    write_package(package, cantilever(n=5, m=2))
    words = ["export", str(package), "--to", "med", "-o", str(out)]
    assert main(words) == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    done = _limited(limit, *words)
    assert done.returncode == 2, done.stderr
    assert "arm.med: File too large" in done.stderr
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    count("export: a file that may not grow", "refused")
