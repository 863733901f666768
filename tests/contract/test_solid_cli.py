"""Solids as a user meets them: `plymotion solid`, and a case with a solid beside a beam."""

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from plymotion.solver.__main__ import main

BOX = """
SetFactory("OpenCASCADE");
DefineConstant[ n = {30, Name "Parameters/n"} ];
Box(1) = {0, -6, -4, 200, 12, 8};
Physical Volume("bar") = {1};  Physical Surface("left") = {1};  Physical Surface("right") = {2};
Mesh.MeshSizeMax = 200 / n;
"""
SOLID = """
format = 1
supports = ["root"]
[mesh]
file = "bar.geo"
unit = "mm"
parameters = { n = 32 }
[materials.aluminium]
kind = "isotropic"
E = 70e9
nu = 0.33
rho = 2700.0
strength = { yield_stress = 250e6 }
[regions.bar]
material = "aluminium"
[interfaces]
root = { at = "left" }
tip = { at = "right", link = "average" }
[loads.end.tip]
at = "tip"
force = [0, 0, 100.0]
[frequencies]
count = 4
"""
CASE = """
format = 1
title = "A bar by two theories"
gravity = [0.0, 0.0, -9.81]
[materials.aluminium]
kind = "isotropic"
E = 70e9
nu = 0.33
rho = 2700.0
strength = { yield_stress = 250e6 }
[sections.bar]
shape = "rectangle"
width = 0.012
height = 0.008
[bodies.bar]
kind = "beam"
length = 0.2
section = "bar"
material = "aluminium"
interfaces = { root = { at = "start" }, tip = { at = "end" } }
modes = [
    { kind = "lowest", count = 4 },
    { kind = "attachment", at = "tip", directions = ["y", "z"] },
]
[variants.solid.bodies.bar]
kind = "solid"
solid = "bar.toml"
second_order = true
interfaces = { root = { at = "left" }, tip = { at = "right", link = "average" } }
[ground.hinge]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.hinge", "bar.root"]
axis = [0.0, 1.0, 0.0]
drive = { smooth_step = { value = 1.0, duration = 0.1 } }
[masses.bob]
mass = 0.1
at = "bar.tip"
[signals.x]
kind = "position"
at = "bar.tip"
component = "x"
[signals.z]
kind = "position"
at = "bar.tip"
component = "z"
[signals.strength]
kind = "strength_ratio"
body = "bar"
[solver]
geometric_stiffening = true
start = "equilibrium"
t_end = 0.3
output_step = 0.001
[runs.beam]
[runs.solid]
variants = ["solid"]
"""


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """A command in the folder: exit code, output, errors. The FEniCSx side is a process."""
    monkeypatch.chdir(tmp_path)
    return lambda *words: (main(list(words)), *capsys.readouterr())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A described bar, and a case."""
    (tmp_path / "bar.geo").write_text(BOX)
    (tmp_path / "bar.toml").write_text(SOLID)
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path


def test_command_tells_inertia_frequencies_and_load_cases(folder: Path, run: Run) -> None:
    code, out, errors = run("solid", "bar.toml", "--json")
    assert code == 0, errors
    found = json.loads(out)
    assert found["mass"] == pytest.approx(2700.0 * 0.2 * 0.012 * 0.008, rel=1e-9)
    root = 1.8751**2 * np.sqrt(70e9 / 2700.0) * 0.008 / np.sqrt(12.0) / 0.2**2 / (2.0 * np.pi)
    assert found["held_hz"][0] == pytest.approx(root, rel=1e-2)
    case = found["cases"]["end"]
    assert case["reactions"]["root"] == pytest.approx([0, 0, -100, 0, 20, 0], abs=1e-4)
    by_mises = pytest.approx(250e6 / case["mises"])
    if case["criterion"] == "von-mises":
        assert case["strength_ratio"] == by_mises
    else:  # the lowest of all criteria of isotropic materials
        assert case["strength_ratio"] < by_mises.expected
    _, again, _ = run("solid", "bar.toml")
    assert "unchanged" in again
    assert "Held" in again


def test_solid_moves_as_the_beam_does(folder: Path, run: Run) -> None:
    code, _, errors = run("case.toml")
    assert code == 0, errors
    signals = {}
    for run in ("beam", "solid"):
        (file,) = (folder / "build").glob(f"*/{run}/result.vtkhdf")
        with h5py.File(file) as result:
            group = result["results/signals"]
            signals[run] = {name: group[name][()] for name in ("x", "z", "strength")}
    for name in ("x", "z"):
        gap = np.abs(signals["solid"][name] - signals["beam"][name]).max()
        assert gap < 1e-3 * 0.2
    lowest = {run: found["strength"].min() for run, found in signals.items()}
    assert lowest["solid"] == pytest.approx(lowest["beam"], rel=0.1)


WRONG = {
    "bar.toml": [
        ('unit = "mm"\n', "", "bar.toml: mesh.unit: missing: bar.geo has no unit of length"),
        ('file = "bar.geo"', 'file = "bar.stl"', 'mesh.file = "bar.stl": there is no file'),
        ('at = "tip"', 'at = "tap"', 'loads.end.tip.at = "tap": no such interface'),
        ('supports = ["root"]', 'supports = ["tip"]', 'expected "rigid": it is held'),
        ('material = "aluminium"', 'material = "alloy"', 'regions.bar.material = "alloy": no such'),
        ("nu = 0.33", "nu = 0.5", "materials.aluminium.nu = 0.5"),
        (
            '{ at = "left" }',
            "{ plane = { point = [0, 0, 0], normal = [0, 0, 0] } }",
            "root.plane.normal = [0, 0, 0]: expected a vector of non-zero length",
        ),
        (
            'material = "aluminium"',
            'material = "aluminium"\naxis_about = { point = [0, 0, 0], direction = [0, 0, 0] }',
            "axis_about.direction = [0, 0, 0]: expected a vector of non-zero length",
        ),
    ],
    "case.toml": [
        ('solid = "bar.toml"', 'solid = "no.toml"', "bodies.bar.solid: no.toml"),
        ('link = "average"', 'link = "section"', "bodies.bar.interfaces.tip.link"),
        ('{ at = "left" }', '{ link = "rigid" }', "expected one of bore, plane, at; found none"),
        ('{ at = "left" }', '{ at = "left", link = "average" }', "it carries the body frame"),
        (
            'interfaces = { root = { at = "left"',
            'modes = [{ kind = "static-axial" }]\ninterfaces = { root = { at = "left"',
            'bodies.bar.modes.0.kind = "static-axial": expected "lowest"',
        ),
    ],
}


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [(file, *each) for file, changes in WRONG.items() for each in changes],
)
def test_wrong_input_is_refused(
    folder: Path, run: Run, file: str, old: str, new: str, words: str
) -> None:
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new))
    command = ["check"] if file == "case.toml" else ["solid", "--check"]
    code, _, errors = run(*command, file)
    assert code == 2
    assert words in errors, errors
    assert not list(folder.glob("build/**/*.json"))


def test_a_bore_that_is_not_there_fails_the_body(folder: Path, run: Run) -> None:
    """The FE side refuses it: file, key, value and what was found; no package is written."""
    bore = "{ bore = { radius = 3e-3, point = [0, 0, 0], direction = [1, 0, 0] } }"
    (folder / "bar.toml").write_text(SOLID.replace('{ at = "left" }', bore))
    code, _, errors = run("solid", "bar.toml")
    assert code == 2
    assert "bar.toml: interfaces.root.bore: no face lies on the cylinder" in errors
    assert not list(folder.glob("build/**/*.vtkhdf"))


def test_a_cad_file_needs_a_material(tmp_path: Path, run: Run) -> None:
    (tmp_path / "part.step").write_text("ISO-10303-21;")
    code, _, errors = run("solid", "part.step")
    assert code == 2
    assert "part.step: --material: missing; expected aluminium, steel, titanium" in errors
    _, _, errors = run("solid", "part.step", "--material", "70e9,0.33")
    assert "--material 70e9,0.33: expected" in errors
