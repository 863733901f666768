"""Steps, refused attempts and time of all shipped mechanisms, and of some hard ones.

.venv/bin/python benchmarks/mechanisms.py [--write docs/speed.md] [WORD ...]

Every run has the default settings of the solver, whatever its case says. Words choose runs whose
names contain one of them. Packages are the shipped ones (no FEniCSx).
"""

import argparse
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from shell_text import replace_between
from solver_text import machine

from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.solver import Solver
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.run.preparation import integrated, prepare

ROOT = Path(__file__).parents[1]
NOT_SHIPPED = {"planned-arm"}  # [fidelity]: two large packages for each body
DEFAULTS = ("integrator", "rtol", "atol_position", "atol_velocity", "max_step", "constraints")
LONGEST = 10.0  # [s]
HEAD = ["mechanism", "end [s]", "steps", "refused", "CPU [s]", "remarks"]
TILTS = (5.0, 0.57, 0.057, 0.0057, 0.00057)  # [deg]
BELT = """
format = 1
title = "mass on a belt"
[ground]
O = {{ position = [0.0, 0.0, 0.0] }}
[bodies.car]
kind = "rigid"
mass = 1.0
inertia = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]
velocity = [{speed}, 0.0, 0.0]
interfaces = {{ a = {{ position = [0.0, 0.0, 0.0] }} }}
[joints.rail]
kind = "prismatic"
between = ["ground.O", "car.a"]
axis = [1.0, 0.0, 0.0]
{forces}
[solver]
t_end = {t_end}
output_step = 0.01
[runs.base]
"""
SPRING = """
[forces.spring]
kind = "coordinate_force"
joint = "rail"
expression = "{law}"
"""
FRICTION = """
[forces.rubs]
kind = "friction"
joint = "rail"
coulomb = 2.0
static = 3.0
stribeck_velocity = 0.1
rest_velocity = {rest}
"""
STOP = """
[forces.stop]
kind = "limit_stop"
joint = "rail"
upper = 0.3
lower = -0.3
stiffness = {k}
restitution = 0.7
"""


class Trial(NamedTuple):
    """A run under a name; `adjust` may write into its model."""

    name: str
    spec: RunSpec
    adjust: Callable[[Model], None] | None = None


def main() -> None:
    """Run the chosen mechanisms and show the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", type=Path)
    parser.add_argument("words", nargs="*")
    wanted = parser.parse_args()
    rows = []
    with TemporaryDirectory() as folder:
        for trial in trials(Path(folder)):
            if not wanted.words or any(word in trial.name for word in wanted.words):
                rows.append(measured(trial))
                print(" | ".join(rows[-1]), flush=True)
    if wanted.write:
        lines = ["| " + " | ".join(row) + " |" for row in [HEAD, ["---"] * len(HEAD), *rows]]
        replace_between(wanted.write, "mechanisms", [*lines, "", machine(None)])


def measured(trial: Trial) -> list[str]:
    """Cells of a row."""
    begin = time.process_time()
    ready = prepare(trial.spec.mechanism, trial.spec.packages, adjust=trial.adjust)
    solution = integrated(ready).solution
    seconds = time.process_time() - begin
    refusals, counters = solution.refusals, solution.counters
    share = counters.rejected / max(counters.steps + counters.rejected, 1)
    why = [f"{refusals.newton} by Newton"] if refusals and refusals.newton else []
    ended = [] if solution.status == "finished" else [f"{solution.status}: {solution.code}"]
    damped = [
        f"{f'damped above {s.cutoff:.0f} rad/s' if s.cutoff else 'short steps'} from {s.t:.2f} s"
        for s in solution.stalls
    ]
    remarks = ", ".join([*ended, *damped, *why])
    cells = [trial.name, f"{solution.t[-1]:.3g}", f"{counters.steps}", f"{share:.0%}"]
    return [*cells, f"{seconds:.2g}", remarks]


def trials(folder: Path) -> Iterator[Trial]:
    """Runs of all cases, then those that are hard."""
    for file in sorted((ROOT / "cases").glob("*/case.toml")):
        name = file.parent.name
        if name in NOT_SHIPPED:
            continue
        build(file, folder / name)
        for run in tomllib.loads(file.read_text())["runs"]:
            spec = defaulted(read_run(folder / name / "runs" / f"{run}.json"))
            yield Trial(f"{name}, {run}", spec)
    yield from loops(folder)
    yield from contacts(folder)
    yield from arms(folder)


def loops(folder: Path) -> Iterator[Trial]:
    """The four-bar with tilted hinges, and its bars stiffer."""
    spec = defaulted(read_run(folder / "misaligned-four-bar/runs/flexible.json"), 12.0)
    for factor in (1.0, 1e3, 1e6):

        def stiffer(model: Model, factor: float = factor) -> None:
            model.K_qq[:] *= factor

        for tilt in np.radians(TILTS):
            axis = [float(np.sin(tilt)), 0.0, float(np.cos(tilt))]
            name = f"four-bar, stiffness x {factor:g}, tilt {tilt:.2g} rad"
            yield Trial(name, spec.changed({"joints.C.axis": axis}), stiffer)


def contacts(folder: Path) -> Iterator[Trial]:
    """Steep friction of a mass on a spring, left alone or on a belt, and stiff stops."""
    pull = SPRING.format(law="-100 * (x - 0.5 * t)")
    swing = SPRING.format(law="-100 * (x - 0.5)")
    for rest in (1e-2, 1e-4, 1e-6, 1e-8):
        rubs = FRICTION.format(rest=rest)
        texts = {"pulled, stick-slip": (pull + rubs, 0.0), "free decay": (swing + rubs, 0.0)}
        for name, (forces, speed) in texts.items():
            spec = sample(folder, BELT.format(speed=speed, forces=forces, t_end=10.0))
            yield Trial(f"friction, {name}, rest velocity {rest:g}", spec)
    for k in (1e5, 1e8, 1e11):
        forces = STOP.format(k=k)
        spec = sample(folder, BELT.format(speed=1.0, forces=forces, t_end=10.0))
        yield Trial(f"stops, restitution 0.7, stiffness {k:g}", spec)


def arms(folder: Path) -> Iterator[Trial]:
    """The controlled arm with high gains, without the limits of its motors."""
    spec = defaulted(read_run(folder / "controlled-arm/runs/free.json"), 1.0)
    motors = [n for n, f in spec.mechanism.forces.items() if f.kind == "controller"]
    for gain in (1.0, 1e3, 1e6):
        changes: dict[str, object] = {}
        for name in motors:
            force = spec.mechanism.forces[name]
            changes |= {
                f"forces.{name}.proportional": force.proportional * gain,
                f"forces.{name}.derivative": force.derivative * gain**0.5,
                f"forces.{name}.upper": None,
                f"forces.{name}.lower": None,
                f"forces.{name}.sample_time": None,
            }
        yield Trial(f"controlled arm, continuous, gain x {gain:g}", spec.changed(changes))


def build(file: Path, folder: Path) -> None:
    """Write run files of a case, with its shipped packages."""
    shipped = ROOT / "tests/packages" / file.parent.name
    write_case(load_case(file), folder, shipped if shipped.exists() else None)


def sample(folder: Path, text: str) -> RunSpec:
    """Return the only run of a case of rigid bodies."""
    file = folder / "case.toml"
    file.write_text(text, encoding="utf-8")
    write_case(load_case(file), folder / "sample", None)
    return read_run(folder / "sample/runs/base.json")


def defaulted(spec: RunSpec, t_end: float | None = None) -> RunSpec:
    """Return a run with default settings, until `t_end` or that of the case if it is short."""
    keys = {f"solver.{key}": Solver.model_fields[key].get_default() for key in DEFAULTS}
    end = t_end or min(spec.mechanism.solver.t_end, LONGEST)
    return spec.changed(keys | {"solver.t_end": end})


if __name__ == "__main__":
    main()
