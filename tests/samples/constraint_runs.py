"""Runs of the sample mechanisms under every treatment of constraints, for tests and benchmarks."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from ida_integrator import SundialsIda
from samples.mechanism_samples import Sample
from scipy_integrators import SCIPY

from plymotion.solver.checks.singularity import SingularityMonitor
from plymotion.solver.dynamics.elements.constraints.treatment import IMPLICIT, Treatment
from plymotion.solver.dynamics.evaluation import series
from plymotion.solver.dynamics.evaluation.accelerations import (
    assemble,
    by_blocks,
    constraint_rates,
    energies,
)
from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.integrators.explicit import RungeKutta5Loop, RungeKutta8Loop
from plymotion.solver.integrators.generalized_alpha import GeneralizedAlpha
from plymotion.solver.integrators.generic.base import Integrator
from plymotion.solver.integrators.generic.drive import Solution, Steps, integrate
from plymotion.solver.integrators.radau import Radau
from plymotion.solver.integrators.step_loop import projection, right_hand_side
from plymotion.solver.integrators.table import new_integrator
from plymotion.solver.math.arrays import Array
from plymotion.solver.mechanism.assembly import treated
from plymotion.solver.mechanism.consistent import consistent_state, redundancy


def joint_reactions(model: Model, t: Array, y: Array, multipliers: Array) -> Array:
    """Return force [N] and moment [N m] of each joint on its two sides, (k, nj, 2, 6).

    At times t (k,), states y (k, n) and multipliers (k, n_c). Global components; the moment is
    about the origin of that side's marker. For redundant joints they are those of least norm.
    """
    n = model.joint_marker.size
    return series.marker_loads(model, t, y, multipliers)[:, :n].reshape(len(y), -1, 2, 6)


@dataclass
class Run:
    """A run and what was seen at the end of each of its steps."""

    model: Model
    solution: Solution
    monitor: SingularityMonitor
    t: np.ndarray  # (k,) ends of steps, the start included
    position: np.ndarray  # (k,) largest |Phi|
    velocity: np.ndarray  # (k,) largest |Phidot|
    energy: np.ndarray  # (k,)


def prepared(sample: Sample, treatment: Treatment) -> tuple[Model, np.ndarray]:
    """The model ready for a treatment, and its consistent start."""
    y0 = consistent_state(sample.model, sample.start, sample.names)
    count = redundancy(sample.model, y0, sample.names).count
    return treated(sample.model, treatment)._replace(redundant=count), y0


def new_generic(name: str, *arguments, **options) -> Integrator:
    """An integrator of y' = f(t, y): one of ours, or of those that benchmarks compare with."""
    make = SCIPY.get(name) or partial(new_integrator, name)
    return make(*arguments, **options)


def new_run(
    model: Model, y0: np.ndarray, treatment: Treatment, integrator: str, t_end: float, **options
) -> Integrator:
    """An integrator as run.py makes it, without a case.

    Treatments that are solved with the step take generalized-alpha, whatever the name, or "ida".
    """
    starts = [0, model.n_pos, model.n_pos + model.n_vel]
    options = {"block_starts": starts} | options
    loops = {"radau": Radau, "rk8": RungeKutta8Loop, "rk5": RungeKutta5Loop}
    if integrator == "radau" or (
        integrator in loops and treatment.name not in IMPLICIT and by_blocks(model)
    ):
        closed = treatment.name == "projection"
        return loops[integrator](model, 0.0, y0, t_end, closed=closed, **options)
    if treatment.name in IMPLICIT:
        options["formulation"] = treatment.name
        if integrator == "ida":
            return SundialsIda(model, 0.0, y0, t_end, **options)
        return GeneralizedAlpha(model, 0.0, y0, t_end, **options)
    if treatment.name == "projection":
        options["project"] = projection(model)
    return new_generic(integrator, right_hand_side(model), 0.0, y0, t_end, **options)


def run(
    sample: Sample,
    treatment: Treatment | str,
    times,
    integrator: str = "rk8",
    rtol: float = 1e-8,
    stop: bool = True,
    **options,
) -> Run:
    """Run a sample to the last of `times`, with absolute tolerances of rtol / 100."""
    treatment = Treatment(treatment) if isinstance(treatment, str) else treatment
    model, y0 = prepared(sample, treatment)
    times = np.asarray(times, dtype=float)
    options = {"rtol": rtol, "atol": 1e-2 * rtol} | options
    made = new_run(model, y0, treatment, integrator, float(times[-1]), **options)
    monitor = SingularityMonitor(model, sample.names, treatment.name, stop=stop)
    monitor.at_start(0.0, y0)
    rows = [_seen(model, 0.0, y0)]

    class Follow:
        note = monitor.note

        def __call__(self, steps: Steps):
            rows.extend(_seen(model, t, y) for t, y in zip(steps.t[1:], steps.y[1:], strict=True))
            return monitor(steps)

    solution = integrate(made, times, watch=Follow())
    t, position, velocity, energy = np.array(rows).T
    return Run(model, solution, monitor, t, position, velocity, energy)


def _seen(model: Model, t: float, y: np.ndarray) -> tuple[float, float, float, float]:
    equations = assemble(model, t, y)
    rates = constraint_rates(model, equations, y)
    balance = energies(model, equations, y).sum() - y[-1]
    return t, np.abs(equations.Phi).max(), np.abs(rates).max(), balance
