"""Which integrator a case asks for, made ready for a mechanism.

A new integrator is a class after contract.py, one entry of `INTEGRATORS`, and its name in
`[solver] integrator` (inputs/case/solver.py).
"""

from typing import Any

import numpy as np

from ..dynamics.constraints.treatment import Treatment, treatment_of
from ..dynamics.model import Model
from ..dynamics.system import by_blocks
from ..math.arrays import Array
from .closures import constrained_system, projection, right_hand_side
from .explicit_stepping import ExplicitLoop, RungeKutta5Loop, RungeKutta8Loop
from .generic import CONSTRAINED, Integrator
from .generic import INTEGRATORS as GENERIC
from .stepping import GeneralizedAlpha, Radau

# By the name in a case file.
INTEGRATORS: dict[str, type[Any]] = {
    "radau": Radau,
    "generalized-alpha": GeneralizedAlpha,
    **GENERIC,
    **CONSTRAINED,
    "rk8": RungeKutta8Loop,
    "rk5": RungeKutta5Loop,
}


def tolerances(model: Model, solver: dict[str, Any]) -> Array:
    """Return absolute tolerances (n,) of positions, velocities and the work."""
    atol = np.full(model.n_pos + model.n_vel + 1, float(solver["atol_velocity"]))
    atol[: model.n_pos] = solver["atol_position"]
    return atol


def make_integrator(
    model: Model, y0: Array, solver: dict[str, Any], treatment: Treatment | None = None
) -> Integrator:
    """Return the integrator that the case asks for, ready to step from t = 0.

    Parameters
    ----------
    model : treated (`treated`)
    y0 : (n,) consistent start
    solver : `[solver]` of a case; it may hold one key more, `fixed_step` [s], without error
        control (benchmarks)
    treatment : the one that the model was prepared for; of `solver` by default
    """
    treatment = treatment or treatment_of(solver)
    kind = INTEGRATORS[solver["integrator"]]
    if issubclass(kind, ExplicitLoop) and not by_blocks(model):
        kind = kind.method  # redundant constraints without a penalty take dense linear algebra
    options: dict[str, Any] = {
        "rtol": solver["rtol"],
        "atol": tolerances(model, solver),
        "block_starts": [0, model.n_pos, model.n_pos + model.n_vel],
    }
    for key in ("max_step", "fixed_step"):
        if solver.get(key) is not None:
            options[key] = solver[key]
    chosen = {"constraints": treatment.name, "spectral_radius": treatment.spectral_radius}
    options |= kind.settings(solver | chosen)
    if kind.takes == "derivative" and treatment.name == "projection" and model.n_constraint:
        options["project"] = projection(model)
    subject = {
        "model": lambda: model,
        "constrained": lambda: constrained_system(model),
        "derivative": lambda: right_hand_side(model),
    }[kind.takes]()
    made: Integrator = kind(subject, 0.0, y0, solver["t_end"], **options)
    return made
