"""Case files of rigid bodies in a few lines, run to their signals."""

import json
from pathlib import Path

import numpy as np

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run

HEAD = 'format = 1\ntitle = "sample"\n'
SOLVER = """
[solver]
t_end = {t_end}
output_step = {step}
integrator = "rk8"
rtol = 1e-10
atol_position = 1e-12
atol_velocity = 1e-12
{more}
[runs.base]
"""


def rigid(name: str, mass: float, inertia, interfaces: dict, **keys) -> str:
    """A rigid body with a diagonal inertia and named points."""
    J = np.diag(np.broadcast_to(np.array(inertia, dtype=float), 3)).tolist()
    points = ", ".join(
        f"{point} = {{ position = {[float(x) for x in at]} }}" for point, at in interfaces.items()
    )
    more = "\n".join(f"{key} = {list(map(float, value))}" for key, value in keys.items())
    return (
        f'[bodies.{name}]\nkind = "rigid"\nmass = {mass}\ninertia = {J}\n'
        f"interfaces = {{ {points} }}\n{more}\n"
    )


def computed_file(file: Path, text: str = "", run: str = "base", packages=None):
    """Result and summary of a run of a case file, which is written first if there is a text."""
    if text:
        file.write_text(text)
    build = file.parent / "build"
    write_case(load_case(file), build, packages)
    return execute(read_run(build / f"runs/{run}.json"), progress=False)


def run_text(folder: Path, text: str, *, t_end: float, step: float, more: str = "", packages=None):
    """Times, signals by name and summary of the only run of a case, written as text."""
    text = HEAD + text + SOLVER.format(t_end=t_end, step=step, more=more)
    result, summary = computed_file(folder / "case.toml", text, packages=packages)
    return result.t, {s.name: s.values for s in result.signals}, summary


def case_runs(repository: Path, name: str, folder: Path, *, coarse: bool = False) -> Path:
    """Check a case of the repository into a folder, with its shipped packages; its run files."""
    case = load_case(repository / "cases" / name / "case.toml", coarse=coarse, sweeps=())
    write_case(case, folder, repository / "tests/packages" / name)
    return folder / "runs"


def short_run(
    repository: Path, name: str, run: str, folder: Path, t_end: float, **changes: object
) -> None:
    """Check a case of the repository into a folder, and compute the begin of one of its runs.

    `changes` are other parts of the mechanism, such as signals.
    """
    file = case_runs(repository, name, folder) / f"{run}.json"
    table = json.loads(file.read_text())
    table["mechanism"] |= changes
    table["mechanism"]["solver"]["t_end"] = t_end
    table["other_runs"] = {}
    file.write_text(json.dumps(table))
    assert main(["run", str(file), "--quiet"]) == 0


def run_case(file: Path, **solver):
    """Times, signals by name and summary of a run, with some keys of its solver changed."""
    spec = read_run(file).changed({f"solver.{key}": value for key, value in solver.items()})
    result, summary = execute(spec, progress=False)
    return result.t, {s.name: s.values for s in result.signals}, summary
