"""Sweeps of small mechanisms in a few lines."""

from pathlib import Path

from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.studies.sweep.file import SweepResult, read_sweep
from plymotion.solver.studies.sweep.sweep_members import SweepSpec, read_sweep_spec

# A ball pushed by a force c t^3: a huge c is more than any step can follow.
BALL = (
    HEAD
    + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)}, velocity=[1.0, 0.0, 0.0])
    + """
[forces.push]
kind = "force"
at = "ball.c"
direction = [1.0, 0.0, 0.0]
law = { polynomial = [0.0, 0.0, 0.0, 1.0] }
[signals.x]
kind = "position"
at = "ball.c"
component = "x"
[signals.v]
kind = "velocity"
at = "ball.c"
component = "x"
"""
    + SOLVER.format(t_end=1.0, step=0.1, more="")
    + """
[variants.implicit.solver]
integrator = "radau"
constraints = "projection"
"""
)
FORCE = '"forces.push.law.polynomial.3"'
MASS = '"bodies.ball.mass"'


def checked(folder: Path, text: str, packages: Path | None = None) -> Path:
    """Check a case, written as text, into folder/build; the folder of its sweep files."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "case.toml"
    file.write_text(text)
    write_case(load_case(file), folder / "build", packages)
    return folder / "build" / "sweeps"


def ball(folder: Path, vary: str, more: str = "") -> Path:
    """The file of a sweep of the ball; `vary` are the lines of its table."""
    sweep = f'[sweeps.s]\nrun = "base"\n{more}\n[sweeps.s.vary]\n{vary}\n'
    return checked(folder, BALL + sweep) / "s.json"


def ball_plan(folder: Path, vary: str, more: str = "") -> SweepSpec:
    """The same, read."""
    return read_sweep_spec(ball(folder, vary, more))


def sweep(file: Path, *options: str) -> int:
    """Run the command for a sweep; its exit code."""
    return main(["sweep", str(file), "--quiet", "--no-figures", *options])


def result(file: Path) -> SweepResult:
    """What the sweep of a case file wrote."""
    return read_sweep(file.with_suffix("") / "sweep.h5")
