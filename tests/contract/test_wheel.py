"""The wheel, installed in a new environment outside the checkout, runs a shipped case."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from plymotion.solver.commands.case_arguments import STARTERS

CASE, RUN = "double-pendulum", "isotropic-soft-free-stiffened"


@pytest.fixture(scope="module")
def wheel(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the sdist and from it the wheel; skip where the build backend is not to be had."""
    folder = tmp_path_factory.mktemp("wheel")
    words = ["-m", "build", "--outdir", str(folder), str(repository)]
    built = subprocess.run([sys.executable, *words], capture_output=True, text=True, cwd=folder)
    if "No matching distribution found for hatchling" in built.stdout + built.stderr:
        pytest.skip("hatchling cannot be installed here")
    assert built.returncode == 0, built.stdout + built.stderr
    (found,) = folder.glob("plymotion-*.whl")
    return found


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program `plymotion` of a new environment, which borrows the dependencies of this one."""
    home = tmp_path_factory.mktemp("outside") / "env"
    venv.create(home, with_pip=False)
    (site,) = home.glob("lib/python*/site-packages")
    words = ["-m", "pip", "--python", str(home / "bin/python"), "install", "--quiet", "--no-deps"]
    subprocess.run([sys.executable, *words, str(wheel)], check=True)
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return home / "bin/plymotion"


def _run(program: Path, *words: str) -> subprocess.CompletedProcess[str]:
    own = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "FENICSX_PYTHON")}
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
    (home / "case").mkdir()
    text = (repository / "cases" / CASE / "case.toml").read_text("utf-8")
    (home / "case/case.toml").write_text(text, "utf-8")
    packages = repository / "tests/packages" / CASE
    done = _run(installed, "case/case.toml", "--run", RUN, "--packages", str(packages))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Report: build/case/report.html" in done.stdout
    summary = home / "build/case" / RUN / "summary.json"
    assert json.loads(summary.read_text("utf-8"))["completed"]


@pytest.mark.parametrize("name", STARTERS)
def test_a_starter_is_written_and_checked(name: str, installed: Path) -> None:
    assert _run(installed, "new", name).returncode == 0
    done = _run(installed, "check", f"{name}/case.toml")
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("no errors\n")
