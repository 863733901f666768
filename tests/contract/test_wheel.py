"""The wheel, made from the sdist, in new environments outside the checkout."""

import json
import os
import subprocess
import sys
import sysconfig
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest
from harness.processes import this_python

from plymotion.solver.commands.case_arguments import STARTERS
from plymotion.solver.commands.setup import HOME
from plymotion.solver.workers.interpreter import recorded

CASE, RUNS = "double-pendulum", ("isotropic", "layup-1")
# As it is, and as a system without fork and signals of POSIX.
SYSTEMS = ({}, {"PLYMOTION_NO_FORK": "1"})


@pytest.fixture(scope="module")
def wheel(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the sdist and from it the wheel; skip where the build backend is not to be had."""
    folder = tmp_path_factory.mktemp("wheel")
    # An environment for each of both takes 4 s, and has what pyproject.toml asks for, as this one.
    alone = [] if find_spec("hatchling") is None else ["--no-isolation"]
    words = ["-m", "build", *alone, "--outdir", str(folder), str(repository)]
    built = this_python(*words, cwd=folder)
    if "No matching distribution found for hatchling" in built.stdout + built.stderr:
        pytest.skip("hatchling cannot be installed here")
    assert built.returncode == 0, built.stdout + built.stderr
    (found,) = folder.glob("plymotion-*.whl")
    return found


@pytest.fixture(scope="module", params=["this Python", 13])
def installed(
    request: pytest.FixtureRequest,
    wheel: Path,
    tools: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """The program `plymotion` of a new environment.

    That of this Python borrows the dependencies of the tests; that of another one gets what the
    wheel asks for, and nothing else.
    """
    home = tmp_path_factory.mktemp("outside") / "env"
    own = request.param == "this Python"
    python = sys.executable
    if not own:
        import find_fenicsx

        other = find_fenicsx.first((request.param,), ("venv",))
        if other is None or sys.version_info[1] == request.param:
            pytest.skip(f"no other Python 3.{request.param} here")
        python = other
    subprocess.run([python, "-m", "venv", "--without-pip", str(home)], check=True)
    (site,) = home.glob("lib/python*/site-packages")
    words = [sys.executable, "-m", "pip", "--python", str(home / "bin/python"), "install"]
    words += ["--quiet", "--no-compile", "--no-deps"]
    words = words if own else [str(tools / "install.sh"), str(home / "bin/python")]
    done = subprocess.run([*words, str(wheel)], capture_output=True, text=True)
    if not own and "No matching distribution found" in done.stderr:
        pytest.skip(f"not installed for Python 3.{request.param}: {done.stderr}")
    assert done.returncode == 0, done.stderr
    if own:
        (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return home / "bin/plymotion"


def _run(program: Path, *words: str, **more: str) -> subprocess.CompletedProcess[str]:
    own = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "FENICSX_PYTHON")} | more
    return subprocess.run(
        [str(program), *words], cwd=program.parents[2], env=own, capture_output=True, text=True
    )


def test_what_the_wheel_holds(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert "plymotion/py.typed" in names
    for part in ("solver/__main__.py", "preprocess/__main__.py", "solver/report/page.css"):
        assert f"plymotion/{part}" in names
    assert "plymotion/solver/commands/starters/panel/panel.geo" in names
    assert "plymotion/meshes/tube.geo" in names
    assert not [n for n in names if n.startswith(("tests/", "cases/")) or n.endswith(".pyc")]


def test_a_shipped_case_runs_outside_the_checkout(installed: Path, repository: Path) -> None:
    home = installed.parents[2]
    where = "import plymotion; print(plymotion.__file__)"
    found = _run(installed.with_name("python"), "-c", where).stdout
    assert found.startswith(str(home)), found
    code = "from importlib.util import find_spec as f; assert f('numba') and f('matplotlib')"
    known = _run(installed.with_name("python"), "-c", code)
    assert known.returncode == 0, known.stderr
    (home / "case").mkdir()
    text = (repository / "cases" / CASE / "case.toml").read_text("utf-8")
    packages = repository / "tests/packages" / CASE
    # What is compiled is kept by version of Python: another one would compile for a minute.
    compiled = "1" if (home / f"env/lib/python3.{sys.version_info[1]}").is_dir() else "0"
    assert "t_end = 1.0" in text
    (home / "case/case.toml").write_text(text.replace("t_end = 1.0", "t_end = 0.001"), "utf-8")
    words = ("case/case.toml", "--jobs", "2", "--force", "--packages", str(packages))
    words += tuple(word for run in RUNS for word in ("--run", run))
    for system in SYSTEMS:
        done = _run(installed, *words, PLYMOTION_COMPILED=compiled, **system)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "Report: build/case/report.html" in done.stdout
        for run in RUNS:
            summary = home / "build/case" / run / "summary.json"
            assert json.loads(summary.read_text("utf-8"))["completed"]
        assert "Numba" not in done.stderr
    drawn = _run(installed, "report", "build/case", "--figures")
    assert drawn.returncode == 0, drawn.stderr
    assert (home / "build/case" / RUNS[0] / "motion.png").is_file()


@pytest.mark.parametrize("installed", ["this Python"], indirect=True, scope="module")
def test_a_section_is_analysed_by_the_python_of_fenicsx(installed: Path, repository: Path) -> None:
    """With a mesh script of the wheel, `tube`; modules beside it are built for this Python."""
    python = os.environ.get("FENICSX_PYTHON") or recorded(repository)
    if python is None:
        pytest.skip("no FEniCSx here")
    home = installed.parents[2]
    text = (HOME / "robot-arm/tube.toml").read_text("utf-8")
    (home / "tube.toml").write_text(text, "utf-8")
    (site,) = home.glob("env/lib/python*/site-packages")
    (site / "gmsh.py").write_text("raise ImportError('of the wrong Python')\n", "utf-8")
    done = _run(installed, "section", "tube.toml", FENICSX_PYTHON=python)
    assert done.returncode == 0, done.stderr
    assert (home / "build/sections/tube/tube.vtkhdf").is_file()
    assert list((home / "build/sections/tube").glob("*.png"))


EACH = """
import os, sys
from plymotion.solver.__main__ import main
os.chdir(sys.argv[1])
for name in sys.argv[2:]:
    sys.argv = ["plymotion", name]
    assert main(["new", name]) == 0, name
    assert main(["check", f"{name}/case.toml"]) == 0, name
"""


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_starter_is_written_and_checked(
    installed: Path, tmp_path: Path, system: dict[str, str]
) -> None:
    """In one process, with the package that is installed."""
    done = _run(installed.with_name("python"), "-c", EACH, str(tmp_path), *STARTERS, **system)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("no errors\n") == len(STARTERS)
