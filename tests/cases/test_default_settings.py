"""All mechanisms of cases and tests with default settings: they end without a stall."""

import re
import tomllib
from pathlib import Path

import pytest
from samples.constraint_runs import prepared
from samples.mechanism_samples import bricard, chain, four_bars, pendulum
from samples.stability_samples import hand
from samples.two_body_samples import stretching_rod, two_bodies

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.solver import Solver
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.advice import INTERVALS, SLOW
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.mechanism.tables import ForceTable
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.preparation import output_times, prepare

ROOT = Path(__file__).parents[2]
NOT_SHIPPED = {"planned-arm"}  # [fidelity]: two large packages for each body
# Of runs that differ in the numbers of their lay-ups, the last one.
CASES = {
    (file.parent.name, re.sub(r"(layup|carbon)-\d+", "", run)): (file.parent.name, run)
    for file in sorted((ROOT / "cases").glob("*/case.toml"))
    if file.parent.name not in NOT_SHIPPED
    for run in tomllib.loads(file.read_text())["runs"]
}.values()
LONGEST = 0.4  # [s]
# Keys of which the default is meant, whatever the case says.
DEFAULTS = ("integrator", "rtol", "atol_position", "atol_velocity", "max_step", "constraints")
STIFF_TIE = (1e9, 1e9, 1e9, 1e6, 1e6, 1e6, 0, 0, 0, 0, 0, 0)
SAMPLES = {
    "pendulum": pendulum,
    "chain of 2": lambda: chain(2),
    "chain of 20": lambda: chain(20),
    "chain of ball joints": lambda: chain(4, "spherical"),
    "four-bar": lambda: four_bars(1),
    "ten four-bars": lambda: four_bars(10),
    "four-bar that nearly fits": lambda: four_bars(1, misfit=1e-4),
    "bricard": bricard,
    "soft bodies": lambda: two_bodies(400.0),
    "stiff bodies": lambda: two_bodies(1e8),
    "very stiff bodies": lambda: two_bodies(1e14),
    "rigid bodies": lambda: two_bodies(None),
    "bodies on a bushing": lambda: two_bodies(
        400.0, forces=[ForceTable("b", "bushing", 0, 4, STIFF_TIE)]
    ),
    "stretching rod": lambda: stretching_rod(1e10),
    "hand on a hinge": lambda: hand("revolute", gravity=True)[0],
    "hand, welded and bent": lambda: hand("fixed", bent=(1e-4, 1e-5, 1e-6, 1e-7))[0],
}


def _ends_well(model, y0, solver, treatment, watch=None):
    made = make_integrator(model, y0, solver, treatment)
    times = output_times(solver.t_end, solver.output_step)
    solution = integrate(made, times, watch=watch)
    assert solution.status in ("finished", "stopped"), solution.message
    assert not solution.stalls
    intervals = max(times.size - 1, INTERVALS)
    assert solution.counters.steps + solution.counters.rejected < SLOW * intervals
    return solution


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    """Run files of all cases."""
    folder = tmp_path_factory.mktemp("build")
    for name in dict.fromkeys(case for case, _ in CASES):
        shipped = ROOT / "tests/packages" / name
        packages = shipped if shipped.exists() else None
        write_case(
            load_case(ROOT / "cases" / name / "case.toml", sweeps=()), folder / name, packages
        )
    return folder


@pytest.mark.parametrize(("case", "run"), CASES)
def test_cases(build, case, run):
    """The beginning of each run; some end before, where a linear body is invalid."""
    spec = read_run(build / case / "runs" / f"{run}.json")
    own = spec.mechanism.solver
    changes = {f"solver.{key}": Solver.model_fields[key].default for key in DEFAULTS}
    spec = spec.changed(changes | {"solver.t_end": min(own.t_end, LONGEST)})
    ready = prepare(spec.mechanism, spec.packages)
    if ready.refused is None:
        args = ready.model, ready.y0, spec.mechanism.solver, ready.treatment
        solution = _ends_well(*args, watch=ready.watch)
        if solution.status == "stopped":
            assert solution.code == "spin-above-clamped-frequency"


@pytest.mark.parametrize("name", SAMPLES)
def test_samples(name):
    treatment = Treatment()
    model, y0 = prepared(SAMPLES[name](), treatment)
    assert (
        _ends_well(model, y0, Solver(t_end=1.0, output_step=0.01), treatment).status == "finished"
    )


@pytest.fixture(scope="module")
def pendulum_runs(build):
    return build / "double-pendulum" / "runs"


def test_a_minute_of_the_double_pendulum(build):
    """At the default accuracy, with the interval of a film; links that bend, and do not stretch."""
    spec = read_run(build / "double-pendulum-limits/runs/isotropic-paper.json")
    changes = {f"solver.{key}": Solver.model_fields[key].default for key in DEFAULTS}
    spec = spec.changed(
        changes | {"solver.t_end": 60.0, "solver.output_step": 0.02, "solver.rtol": 1e-5}
    )
    ready = prepare(spec.mechanism, spec.packages)
    _ends_well(ready.model, ready.y0, spec.mechanism.solver, ready.treatment, ready.watch)


def test_a_million_times_the_stiffness_takes_about_as_many_steps(pendulum_runs):
    """At the default accuracy; K of the arm is that of a material a million times as stiff."""
    from dataclasses import replace

    spec = read_run(pendulum_runs / "isotropic.json").changed({"solver.rtol": 1e-5})
    steps = []
    for factor in (1.0, 1e6):
        arm = spec.packages["arm"]
        stiff = replace(arm, stiffness=factor * arm.stiffness)
        ready = prepare(spec.mechanism, spec.packages | {"arm": stiff})
        solution = _ends_well(ready.model, ready.y0, spec.mechanism.solver, ready.treatment)
        steps.append(solution.counters.steps)
    assert 0.5 < steps[1] / steps[0] < 2.0
