"""`plymotion section` as a user calls it: the real command, the real FEniCSx of this machine."""

import json
import os
import re
import signal
import subprocess
import sys
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from harness.dask_cluster import until
from harness.struck_samples import narrow_pipe

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.package.section.section_file import read_section
from plymotion.solver.workers import interpreter
from plymotion.solver.workers.interpreter import find_interpreter
from plymotion.solver.workers.launch import kept_preprocessors

BAR = """
format = 1
title = "A bar of one ply"
convention = "contour"

[mesh]
shape = "rectangle"
width = 0.06
height = 0.015

[materials.cfrp]
kind = "orthotropic"
E1 = 129.2e9
E2 = 9.4e9
E3 = 9.4e9
G12 = 5.2e9
G13 = 4.3e9
G23 = 2.5e9
nu12 = 0.3
nu13 = 0.3
nu23 = 0.22
rho = 1550.0
strength = { Xt = 2.0e9, Xc = 1.2e9, Yt = 50e6, Yc = 200e6, S12 = 80e6 }

[laminates.all]
material = "cfrp"
angles_deg = [15]

[regions.section]
laminate = "all"
"""
STUDY = """
format = 1
sections = ["bar.toml"]

[[sweep]]
key = "laminates.all.angles_deg"
values = {values}
"""
MARK = "PLYMOTION_TEST"
MANY = 16  # sections of a batch that is stopped after the third: about 0.1 s each


pytestmark = pytest.mark.usefixtures("fenicsx")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "bar.toml").write_text(BAR)
    return tmp_path


@pytest.fixture
def mark() -> str:
    """A word in the environment of every process that a test starts."""
    return uuid.uuid4().hex


def command(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", "plymotion.solver", "section", *map(str, arguments)]


Done = subprocess.CompletedProcess[str]
Run = Callable[..., Done]


def process(folder: Path, *arguments: str | Path, **environment: str) -> Done:
    return subprocess.run(
        command(*arguments),
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, **environment},
        timeout=300,
    )


@pytest.fixture
def run(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Iterator[Run]:
    """The command in this process; the FEniCSx side is one process for the runs of a test."""
    monkeypatch.chdir(folder)

    def done(*arguments: str | Path, **environment: str) -> Done:
        capfd.readouterr()
        with pytest.MonkeyPatch.context() as patch:
            for name, value in environment.items():
                patch.setenv(name, value)
            code = main(["section", *map(str, arguments)])
        return Done(arguments, code, *capfd.readouterr())

    with kept_preprocessors():
        yield done


def test_one_section_from_text_to_files(folder: Path, run: Run) -> None:
    """And figures, which are drawn once."""
    first = process(folder, "bar.toml", "--loads=1e4,0,0,0,20,0")
    assert first.returncode == 0, first.stderr
    lines = first.stdout.splitlines()
    assert lines[0] == "bar: A bar of one ply"
    assert max(map(len, lines)) <= 100
    assert any(line.startswith("Error estimate  ") for line in lines)
    assert any(line.startswith("section 0 cfrp") for line in lines)
    assert any(line.startswith("least by tsai-wu: ") for line in lines)
    file = folder / "build" / "sections" / "bar" / "bar.vtkhdf"
    assert f"Files           {file.relative_to(folder)}" in lines
    section = read_section(file)
    os.utime(file, (1, 1))
    figures = sorted(file.parent.glob("*.png"))
    assert len(figures) == 2, first.stderr
    assert all(str(figure.relative_to(folder)) in first.stdout for figure in figures)
    times = [figure.stat().st_mtime_ns for figure in figures]
    assert run("bar.toml").returncode == 0
    assert [figure.stat().st_mtime_ns for figure in figures] == times

    second = run("bar.toml", "--json")
    assert second.returncode == 0, second.stderr
    found = json.loads(second.stdout)
    assert list(found) == [
        *("K", "M", "order", "shear_centre", "tension_centre", "mass_centre"),
        *("initial_curvature", "error_estimate", "dofs", "seconds", "warnings"),
    ]
    assert np.array_equal(found["K"], section.K)
    assert np.array_equal(found["error_estimate"], section.error_estimate)
    assert file.stat().st_mtime == 1, "it was made again"

    # A section file is shown without FEniCSx, in any order.
    shown = run(file, "--json", "--order", "becas", FENICSX_PYTHON="nowhere")
    K = np.array(json.loads(shown.stdout)["K"])
    assert K[2, 2] == section.K[0, 0]
    assert K[5, 5] == section.K[3, 3]


def test_accuracy_refines_and_says_what_it_cost(folder: Path, run: Run) -> None:
    done = run("bar.toml", "--no-figures", "--accuracy", "2e-6")
    assert done.returncode == 0, done.stderr
    assert "refined in steps:" in done.stdout
    section = read_section(folder / "build" / "sections" / "bar" / "bar.vtkhdf")
    steps = section.provenance["refinements"]
    assert len(steps) > 1
    assert steps[0]["error"] > 2e-6 >= steps[-1]["error"]


def test_errors_name_file_and_key(folder: Path, run: Run) -> None:
    (folder / "bad.toml").write_text(BAR.replace("angles_deg", "angle_deg"))
    done = run("bad.toml")
    assert (done.returncode, done.stdout) == (2, "")
    assert "error: bad.toml: laminates.all.angle_deg: unknown key" in done.stderr
    assert "did you mean 'angles_deg'" in done.stderr

    # An error that only the FE side sees names the description as well.
    (folder / "part.geo").write_text("Rectangle(1) = {0, 0, 0, 1, 1};\n")
    own = BAR.replace('shape = "rectangle"\nwidth = 0.06\nheight = 0.015', 'file = "part.geo"')
    (folder / "own.toml").write_text(own)
    done = run("own.toml", "bar.toml", "--no-figures", "--no-estimate")
    assert done.returncode == 2
    assert "error: own.toml: " in done.stderr
    assert "bar: A bar of one ply" in done.stdout, "one failure stops no other"


def test_unusable_interpreter_is_named(folder: Path, run: Run) -> None:
    done = run("bar.toml", FENICSX_PYTHON=sys.executable)
    if done.returncode == 0:
        pytest.skip("this very Python has FEniCSx")
    assert done.returncode == 2
    assert f"error: FENICSX_PYTHON = {sys.executable}: cannot use FEniCSx: no " in done.stderr


def test_without_fenicsx_the_message_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("FENICSX_PYTHON", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(interpreter, "SYSTEM_PYTHON", str(tmp_path / "python3"))
    monkeypatch.setattr(interpreter, "checkouts", list)
    remedy = r"(?s)`make fenicsx`.*\n  Debian, Ubuntu: apt-get .*\n  conda: conda install [^\n]*$"
    with pytest.raises(InputError, match=remedy):
        find_interpreter()


def test_a_missing_compiler_is_named_with_its_packages(
    folder: Path, run: Run, fenicsx: str, tmp_path: Path
) -> None:
    nothing = {"CC": "/nowhere/cc", "XDG_CACHE_HOME": str(tmp_path)}
    done = run("bar.toml", FENICSX_PYTHON=fenicsx, **nothing)
    assert done.returncode == 2
    assert "DOLFINx needs a C compiler (gcc) and Python's headers (python3-dev)" in done.stderr
    assert not (folder / "build/sections/bar/bar.vtkhdf").exists()


def test_python_path_is_the_word_of_the_user(folder: Path, run: Run, fenicsx: str) -> None:
    """A module there is found before that of FEniCSx; test_wheel.py has an installed package."""
    (folder / "gmsh.py").write_text("raise ImportError('of the wrong Python')\n")
    path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    words = ("bar.toml", "--no-figures", "--no-estimate")
    done = run(*words, PYTHONPATH=path, FENICSX_PYTHON=fenicsx)
    assert done.returncode == 2
    assert "of the wrong Python" in done.stderr


def test_study_with_a_bad_variant_and_shards(folder: Path, run: Run) -> None:
    (folder / "study.toml").write_text(STUDY.format(values="[[0], [95], [30], [45], [60]]"))
    batch = ("--batch", "study.toml", "--out", "out", "--no-estimate")
    for k in (1, 2):
        part = run(*batch, "--shard", f"{k}/2")
        assert part.returncode == (2 if k == 1 else 0)
    made = sorted((folder / "out").glob("*/*.vtkhdf"))
    assert [path.stem for path in made] == ["bar-1", "bar-3", "bar-4", "bar-5"]
    names = [
        name
        for k in (1, 2)
        for name in json.loads((folder / "out" / f"summary-{k}-of-2.json").read_text())
    ]
    assert names == ["bar-1", "bar-2", "bar-3", "bar-4", "bar-5"]

    whole = run(*batch, "--json")
    assert whole.returncode == 2
    assert "error: bar-2: bar.toml: laminates.all.angles_deg.0 = 95" in whole.stderr
    table = json.loads(whole.stdout)
    assert table == json.loads((folder / "out" / "summary.json").read_text())
    status = {name: row["status"] for name, row in table.items()}
    assert status == {**dict.fromkeys(names, "unchanged"), "bar-2": "failed"}
    K = read_section(made[1]).K
    assert np.array_equal(table["bar-3"]["K"], K)
    assert table["bar-3"]["changes"] == {"laminates.all.angles_deg": [30]}
    assert len((folder / "out" / "summary.csv").read_text().splitlines()) == 6


def processes(mark: str) -> dict[int, str]:
    """Command lines of the processes that carry a mark, by number."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                if f"{MARK}={mark}".encode() in (entry / "environ").read_bytes():
                    found[int(entry.name)] = (entry / "cmdline").read_text().replace("\0", " ")
            except OSError:
                continue  # it has ended, or is not ours
    return found


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_stopped_batch_goes_on_where_it_was(
    folder: Path, mark: str, number: signal.Signals, run: Run
) -> None:
    """The batch cannot end before the signal: it waits for a reader of its progress."""
    many = MANY
    values = [[i] for i in range(many)]
    (folder / "study.toml").write_text(STUDY.format(values=values))
    batch = ("--batch", "study.toml", "--out", "out", "--no-estimate")
    made = (folder / "out").glob
    reader, writer = narrow_pipe(80)  # three lines or four
    with subprocess.Popen(
        command(*batch, "--jobs", "2"),
        stdout=subprocess.DEVNULL,
        stderr=writer,
        cwd=folder,
        env={**os.environ, MARK: mark},
    ) as process:
        os.close(writer)
        until(lambda: len(list(made("*/bar-*.vtkhdf"))) > 2)
        process.send_signal(number)
        with open(reader, encoding="utf-8") as stream:
            errors = stream.read()
        process.wait(60)
    if number == signal.SIGINT:
        assert process.returncode == 130
        assert f"of {many} sections are complete and kept" in errors
        # An MPI may start a daemon for a program without mpirun, which ends a moment after it.
        until(lambda: not processes(mark), 5.0)
        assert not list(made("*/.*")), "an unfinished file is left"
    else:
        until(lambda: not processes(mark), 20.0)
    kept = {path: path.stat().st_mtime_ns for path in made("*/bar-*.vtkhdf")}
    assert 2 < len(kept) < many
    for path in kept:
        read_section(path)

    # The others are left out but a few; names have two digits.
    left = values[: max(9, *(int(path.stem[-2:]) for path in kept)) + 3]
    (folder / "study.toml").write_text(STUDY.format(values=left))
    again = run(*batch, "--json")
    assert again.returncode == 0, again.stderr
    status = [row["status"] for row in json.loads(again.stdout).values()]
    assert status.count("unchanged") == len(kept)
    assert status.count("built") == len(left) - len(kept) > 0
    assert {path: path.stat().st_mtime_ns for path in kept} == kept


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="looks for processes in /proc")
def test_lost_worker_takes_only_its_section_with_it(folder: Path, mark: str) -> None:
    """The batch cannot end before its worker: it waits for a reader of its progress."""
    many = 8
    values = [[i] for i in range(many)]
    (folder / "study.toml").write_text(STUDY.format(values=values))
    reader, writer = narrow_pipe(80)

    def preprocessors() -> list[int]:
        return [pid for pid, line in processes(mark).items() if "preprocess section" in line]

    with subprocess.Popen(
        command("--batch", "study.toml", "--out", "out", "--no-estimate", "--json"),
        stdout=subprocess.PIPE,
        stderr=writer,
        text=True,
        cwd=folder,
        env={**os.environ, MARK: mark},
    ) as process:
        os.close(writer)
        until(lambda: bool(preprocessors()))
        (worker,) = preprocessors()
        until(lambda: len(list((folder / "out").glob("*/bar-*.vtkhdf"))) > 2)
        # One rank alone: no daemon of Open MPI, which takes a quarter of a second to start.
        assert not [line for line in processes(mark).values() if "orted" in line]
        os.kill(worker, signal.SIGKILL)
        with open(reader, encoding="utf-8") as stream:
            errors = stream.read()
        output, _ = process.communicate(timeout=120)
    assert process.returncode == 2
    status = [row["status"] for row in json.loads(output).values()]
    assert (status.count("built"), status.count("failed")) == (many - 1, 1)
    assert "the preprocessor ended unexpectedly: killed by signal 9" in errors


def test_many_plies_show_what_is_done(folder: Path) -> None:
    """1000 plies take half a minute: a line within two seconds of work, without a terminal."""
    angles = ", ".join(["15"] * 1000)
    text = BAR.replace("[15]", f"[{angles}]").replace("0.015", "0.125")
    (folder / "many.toml").write_text(text)
    with subprocess.Popen(
        command("many.toml", "--no-figures", "--json"),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
    ) as process:
        line = process.stderr.readline()
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert re.fullmatch(r"(starting|many: .*), 2 s\n", line)
    assert process.returncode == 130
