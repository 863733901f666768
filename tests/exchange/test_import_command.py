"""`plymotion import`, and a run with the package."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from samples.brick_model import Brick, brick
from samples.exchange_samples import bar, request, write_matrices

from plymotion.preprocess.exchange import from_matrices
from plymotion.preprocess.exchange.__main__ import main as exchange
from plymotion.solver.__main__ import main
from plymotion.solver.package import read_package
from plymotion.solver.results import read_result

CASE = """\
format = 1
title = "A bar of another code"
gravity = [0.0, 0.0, -9.81]

[bodies.arm]
kind = "package"
package = "arm.vtkhdf"

[joints.root]
kind = "fixed"
between = ["ground.origin", "arm.root"]

[ground.origin]
position = [0.0, 0.0, 0.0]

[signals.tip_z]
kind = "position"
at = "arm.tip"
component = "z"

[solver]
t_end = 0.02
output_step = 1e-3
integrator = "radau"

[runs.base]
"""


@pytest.fixture(scope="module")
def body() -> Brick:
    return bar()


@pytest.fixture(scope="module")
def folder(body: Brick, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("import")
    write_matrices(folder, body)
    return folder


def test_the_command_makes_the_package(
    body: Brick, folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without `-o` it is in the current folder, named like the import file."""
    out = folder / "arm.vtkhdf"
    monkeypatch.chdir(folder)
    assert main(["import", "arm.toml"]) == 0
    told = capfd.readouterr()
    assert "arm.vtkhdf: arm, 12 modes, 61.5" in told.out
    assert "6 vibrations of" in told.err
    package = read_package(out)
    direct = from_matrices(body.M, body.K, body.nodes, body.dofs, damping_ratio=0.01, **request())
    np.testing.assert_allclose(package.frequencies, direct.frequencies, rtol=1e-9)
    np.testing.assert_allclose(package.damping, direct.damping, rtol=1e-9, atol=1e-9)
    assert package.provenance["source"]["files"]["stiffness"] == "K.mtx"


def test_the_package_runs(body: Brick, folder: Path) -> None:
    """Released from rest under its weight, the bar swings about its static deflection."""
    write = folder / "arm.vtkhdf"
    if not write.is_file():
        assert main(["import", str(folder / "arm.toml"), "-o", str(write), "--quiet"]) == 0
    case = folder / "case.toml"
    case.write_text(CASE)
    out = folder / "build"
    assert main(["check", str(case), "--out", str(out)]) == 0
    assert main(["run", str(out / "runs" / "base.json"), "--quiet"]) == 0
    result = read_result(out / "base" / "result.vtkhdf")
    (z,) = (signal.values for signal in result.signals)
    package = read_package(write)
    g = 9.81
    load = -g * package.invariants.S_B[2]
    still = package.interfaces[1].phi_B[2] @ (load / np.diag(package.stiffness))
    assert 1.7 * still > z.min() > 2.1 * still


def test_progress_and_errors_come_from_a_process_of_its_own(folder: Path) -> None:
    """The exit code and the message of the light preprocessor are those of the command."""
    command = [sys.executable, "-m", "plymotion.solver", "import", "none.toml", "-o", "x.vtkhdf"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("error: none.toml: no such file")


INVALID = {
    "damping_ratio = 0.01": ("damping_ratio = -0.5", "damping_ratio = -0.5: expected a fraction"),
    'body = "arm"': ('body = "a\\nb"', "body: the name 'a\\\\nb'"),
    "tip": ("a/b", "its interfaces: no valid package is made of it: interfaces: 'a/b'"),
}


@pytest.mark.parametrize("old", INVALID)
def test_what_validate_would_refuse_is_not_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str
) -> None:
    """The message names the file of the source, and nothing is left, hidden or not."""
    new, told = INVALID[old]
    file = write_matrices(tmp_path / "in", brick((0.5, 0.04, 0.01), (4, 2, 1), density=2700.0))
    text = file.read_text(encoding="utf-8")
    if old == "tip":
        text, old, new = text.replace('"tip"', '"a/b"'), "tip = {", '"a/b" = {'
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    out = tmp_path / "out" / "arm.vtkhdf"
    out.parent.mkdir()
    assert exchange(["import", str(file), "--out", str(out), "--quiet"]) == 2
    shown = capsys.readouterr().err
    assert f"error: {file}: " in shown
    assert told in shown
    assert not any(out.parent.iterdir())
