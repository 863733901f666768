"""Which integrator a case asks for, made ready for a mechanism, with its tolerances."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..dynamics.analysis.recovery import scales, shape_sizes
from ..dynamics.elements.constraints.treatment import Treatment
from ..dynamics.evaluation.accelerations import by_blocks
from ..dynamics.evaluation.instants import Called
from ..dynamics.model.model import Model, state_size
from ..errors import InputError
from ..math.arrays import Array, distinct
from ..math.expressions.operations import LOAD
from .breakpoints import breaks
from .explicit import ExplicitLoop
from .generic.base import Integrator
from .step_loop import projection, right_hand_side
from .table import EXAMPLES, INTEGRATORS, treatment_of

# The work enters the energy balance alone, no motion depends on it. The estimate of the error of a
# quadrature by radau is of order 3 and contains the reactions' vibrations: with a share of 1, an
# arm with a smooth drive takes 1.8 times the steps at the same error of motion and balance.
WORK_SHARE = 10.0


def tolerances(model: Model, y0: Array, solver: Any) -> Array:
    """Return absolute tolerances (n,) of positions, velocities and the work of a run from y0 (n,).

    With L, V and E of dynamics/analysis/recovery.py, and d_j the displacement by mode j: rtol L of
    positions, rtol of Euler parameters, rtol L / d_j of modal coordinates; rtol V, rtol V / L and
    rtol V / d_j of their rates; WORK_SHARE rtol E of the work. The keys of a case have precedence,
    for all components alike.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y0 : state at the start (n,)
    solver : keys rtol, atol_position, atol_velocity, t_end and integrator of the case
    """
    size = scales(model, y0, solver.t_end)
    atol = np.full(state_size(model), size.energy)
    v_end = model.n_pos + model.n_vel
    atol[v_end : v_end + model.n_aux] = model.quantities.scale
    for i in range(model.n_body):
        shapes = shape_sizes(model, i)
        a, j = int(model.pos_start[i]), model.n_pos + int(model.vel_start[i])
        atol[a : a + 3], atol[j : j + 3] = size.length, size.speed
        atol[a + 3 : a + 7], atol[j + 3 : j + 6] = 1.0, size.speed / size.length
        ends = a + 7 + shapes.size, j + 6 + shapes.size
        atol[a + 7 : ends[0]], atol[j + 6 : ends[1]] = size.length / shapes, size.speed / shapes
    atol[-1] *= WORK_SHARE
    atol *= INTEGRATORS[solver.integrator].local_tolerance(solver.rtol, treatment_of(solver).name)
    if solver.atol_position is not None:
        atol[: model.n_pos] = solver.atol_position
    if solver.atol_velocity is not None:
        atol[model.n_pos : v_end] = solver.atol_velocity
        atol[-1] = solver.atol_velocity
    return atol


def blocks(model: Model) -> list[int]:
    """Return the first index of each block of the error norm: positions of each body, velocities
    of each body, auxiliary states, work.
    """
    j = model.n_pos + np.asarray(model.vel_start)
    more = range(model.n_pos + model.n_vel, state_size(model))
    return [*map(int, model.pos_start), *map(int, j), *more]


def make_integrator(
    model: Model,
    y0: Array,
    solver: Any,
    treatment: Treatment | None = None,
    *,
    fixed_step: float | None = None,
    atol: Array | None = None,
    functions: Sequence[Called] = (),
) -> Integrator:
    """Return the integrator that the case asks for, ready to step from t = 0.

    Parameters
    ----------
    model : treated (`treated`)
    y0 : (n,) consistent start
    solver : `[solver]` of a case
    treatment : the one that the model was prepared for; of `solver` by default
    fixed_step : [s], without error control
    atol : (n,) absolute tolerances; of this model and start by default
    functions : of sampled states (dynamics/evaluation/evaluation.py)

    Raises
    ------
    InputError
        An integrator that has no place for the auxiliary states of the model.
    """
    treatment = treatment or treatment_of(solver)
    kind: type[Any] = INTEGRATORS[solver.integrator]
    if issubclass(kind, ExplicitLoop) and not by_blocks(model):
        kind = kind.method  # redundant constraints without a penalty take dense linear algebra
    if model.n_aux and not kind.auxiliary:
        able = [name for name, other in INTEGRATORS.items() if other.auxiliary]
        raise InputError(
            f'solver.integrator = "{solver.integrator}": does not integrate the auxiliary states '
            "that controllers, bristle_friction and expressions of angles have; expected "
            f"{', '.join(able[:EXAMPLES])} ..."
        )
    jumps = (model.quantities.period > 0.0).any() or model.quantities.event_state.size
    if jumps and not kind.samples:
        able = [name for name, other in INTEGRATORS.items() if other.samples]
        raise InputError(
            f'solver.integrator = "{solver.integrator}": does not stop at the instants of '
            f"impacts, or of controllers with a sample_time; expected {' or '.join(able)}"
        )
    options: dict[str, object] = {
        "rtol": kind.local_tolerance(solver.rtol, treatment.name),
        "atol": tolerances(model, y0, solver) if atol is None else atol,
        "block_starts": blocks(model),
    }
    broken = breaks(model, solver.t_end)
    options |= {"kinks": distinct(broken.kinks, broken.narrow), "jumps": broken.jumps}
    if kind.takes == "model":
        options["sharp"] = broken.kinks
    if fixed_step is not None:
        options["fixed_step"] = fixed_step
    elif solver.max_step is not None:
        options["max_step"] = solver.max_step
    else:
        options["max_step"] = broken.longest
    if functions:
        options["functions"] = functions
    options |= {key.name: getattr(solver, key.name) for key in kind.keys}
    options |= kind.for_treatment(treatment.name)
    if kind.takes == "derivative" and treatment.name == "projection" and model.n_constraint:
        options["project"] = projection(model)
    subject = model if kind.takes == "model" else right_hand_side(model)
    made: Integrator = kind(subject, 0.0, y0, solver.t_end, **options)
    if fixed_step is None and np.any(model.quantities.programs.code == LOAD):
        from .force_variation import HiddenForces  # not for expressions of time alone

        if unseen := HiddenForces(model, made.points, made.rates_fit):
            made.hidden, made.chattering = unseen.stops, unseen.chattering
    if fixed_step is None and solver.max_step is None:  # else the user has chosen the steps
        made.unsearched = broken.unsearched
    made.vibrates = bool(
        model.n_mode.any() or model.layout.element_row.size or (model.quantities.along >= 0).any()
    )
    return made
