"""`plymotion shell` as a user calls it, with the real FEniCSx of this machine."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.package.common.files import RECORD
from plymotion.solver.package.shell.shell_file import read_shell

STRIP = """
DefineConstant[ n = {4, Name "Parameters/n"} ];
Point(1) = {0, 0, 0};  Point(2) = {400, 0, 0};  Point(3) = {400, 40, 0};  Point(4) = {0, 40, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 4};  Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};  Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 10 * n + 1;  Transfinite Curve {2, 4} = n + 1;
Transfinite Surface {1} Alternate;
Physical Surface("strip") = {1};  Physical Curve("root") = {4};  Physical Curve("tip") = {2};
"""
DESCRIPTION = """
format = 1
title = "A strip of four plies"

[mesh]
file = "strip.geo"             # drawn in mm
scale = 1e-3
parameters = { n = 4 }

[materials.cfrp]
kind = "orthotropic"
E1 = 142e9
E2 = 9.8e9
E3 = 9.8e9
G12 = 6.0e9
G13 = 6.0e9
G23 = 4.8e9
nu12 = 0.0
nu13 = 0.0
nu23 = 0.42
rho = 1600.0
strength = { Xt = 2.0e9, Xc = 1.2e9, Yt = 50e6, Yc = 200e6, S12 = 80e6 }

[laminates.skin]
material = "cfrp"
angles_deg = [0, 90]
ply_thickness = 0.5e-3
symmetric = true

[regions.strip]
laminate = "skin"
axis = [1, 0, 0]

[supports.root]
at = "root"
fixed = "all"

[loads.bending.tip]
at = "tip"
force = [0, 0, 2.0]

[probes.tip]
at = "tip"
what = "uz"

[frequencies]
count = 2
"""


pytestmark = pytest.mark.usefixtures("fenicsx", "one_fenicsx")


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def shell(strip: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """The command in the folder and in this process: exit code, output, errors."""
    monkeypatch.chdir(strip)
    return lambda *words: (main(["shell", *words]), *capsys.readouterr())


@pytest.fixture(scope="module")
def strip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("strip")
    (folder / "strip.geo").write_text(STRIP)
    (folder / "strip.toml").write_text(DESCRIPTION)
    command = [sys.executable, "-m", "plymotion.solver", "shell", "strip.toml"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr
    (folder / "screen.txt").write_text(done.stdout)
    return folder


def test_from_text_to_files(strip: Path) -> None:
    text = (strip / "screen.txt").read_text()
    assert max(map(len, text.splitlines())) <= 100
    assert "strip: A strip of four plies" in text
    assert "[0/90]s of cfrp" in text
    made = {file.name for file in (strip / "build" / "shells" / "strip").iterdir()}
    assert made == {
        "strip.json",
        "strip.vtkhdf",
        "strip-bending.png",
        "strip-mode-1.png",
        "strip-mode-2.png",
        RECORD,
    }
    assert all(f"build/shells/strip/{name}" in text for name in made - {"strip.json", RECORD})


def test_numbers_of_a_cantilever(shell: Run) -> None:
    """Without contraction (nu12 = 0) the strip is a beam: w = F L^3 / 3 E I + F L / (k G A)."""
    code, out, errors = shell("strip.toml", "--json")
    assert code == 0, errors
    table = json.loads(out)
    length, width, ply, force = 0.4, 0.04, 0.5e-3, 2.0
    inner, outer = ply**3, (2 * ply) ** 3 - ply**3  # EI = 2 width int E z^2 dz over the upper half
    EI = width * 2.0 / 3.0 * (142e9 * outer + 9.8e9 * inner)
    Ds = table["laminates"]["skin"]["Ds"][0][0]
    deflection = force * length**3 / (3 * EI) + force * length / (Ds * width)
    case = table["cases"]["bending"]
    assert case["probes"]["tip"]["uz"] == pytest.approx(deflection, rel=2e-3)
    assert case["reactions"]["root"][2] == pytest.approx(-force, rel=1e-9)
    assert case["imbalance"] < 1e-8
    # at the face of the top ply, which pulls the strip down; in a cell of 10 mm at the clamp
    stress = case["plies"]["skin"][3]["stress"]["11"]
    assert 0.96 < stress / (-142e9 * force * length * 2 * ply / EI) < 1.0
    mass = 1600.0 * 4 * ply * width
    first = 1.8751040687**2 / (2 * 3.141592653589793) * (EI / (mass * length**4)) ** 0.5
    assert table["frequencies_hz"][0] == pytest.approx(first, rel=5e-3)


def test_second_method(shell: Run) -> None:
    code, out, errors = shell("strip.toml", "--verify", "--no-figures", "--out", "judged")
    assert code == 0, errors
    assert "\nSecond method   " in out
    _, out, _ = shell("judged/strip/strip.vtkhdf", "--json")
    assert "of which meshes explain" in json.loads(out)["verification"]


def test_what_is_there_is_shown_again(strip: Path, shell: Run) -> None:
    file = strip / "build" / "shells" / "strip" / "strip.vtkhdf"
    assert read_shell(file).name == "strip"
    code, out, errors = shell(str(file), "--no-figures")
    assert code == 0, errors
    assert "strip.vtkhdf (unchanged)" in out


def test_names_that_only_gmsh_knows(strip: Path, shell: Run) -> None:
    (strip / "wrong.toml").write_text(DESCRIPTION.replace('at = "root"', 'at = "rot"'))
    code, _, errors = shell("wrong.toml")
    assert code == 2
    assert "error: wrong.toml: " in errors
    assert "rot" in errors
    assert "did you mean 'root'" in errors
    assert "Traceback" not in errors
