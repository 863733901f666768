"""Which integrator a case asks for, made ready for a mechanism."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from ..dynamics.auxiliary import Called
from ..dynamics.constraints.treatment import IMPLICIT, TREATMENTS, Treatment, TreatmentKeys
from ..dynamics.derivative import by_blocks
from ..dynamics.model import Model
from ..errors import InputError
from ..math.arrays import Array
from .breakpoints import breaks
from .closures import constrained_system, projection, right_hand_side
from .explicit_stepping import ExplicitLoop
from .generic import Integrator
from .table import INTEGRATORS
from .tolerances import ToleranceKeys, blocks, tolerances

EXAMPLES = 3  # integrators that a message names


class SolverKeys(ToleranceKeys, TreatmentKeys, Protocol):
    """The keys of `[solver]` that all integrators share; their own ones stand beside these."""

    @property
    def integrator(self) -> str:
        """A name of `INTEGRATORS`."""

    @property
    def max_step(self) -> float | None:
        """Largest step [s]."""


def treatment_of(solver: SolverKeys) -> Treatment:
    """Return the treatment of constraints that a case asks for.

    Raises
    ------
    InputError
        A treatment that the integrator does not support.
    """
    treatment, own = Treatment.of(solver), INTEGRATORS[solver.integrator].treatments
    possible = own or tuple(t for t in TREATMENTS if t not in IMPLICIT)
    if treatment.name not in possible:
        able = [name for name, kind in INTEGRATORS.items() if treatment.name in kind.treatments]
        others = [name for name, kind in INTEGRATORS.items() if not kind.treatments]
        wanted = (
            "integrator = " + " or ".join(f'"{name}"' for name in able)
            if treatment.name in IMPLICIT
            else "one that does not solve the constraints within the step "
            f"({', '.join(others[:EXAMPLES])} ...)"
        )
        raise InputError(
            f'solver.constraints = "{treatment.name}" with integrator = "{solver.integrator}": '
            f"expected {wanted}, or constraints = {' or '.join(possible)}"
        )
    return treatment


def make_integrator(
    model: Model,
    y0: Array,
    solver: SolverKeys,
    treatment: Treatment | None = None,
    *,
    fixed_step: float | None = None,
    functions: Sequence[Called] = (),
) -> Integrator:
    """Return the integrator that the case asks for, ready to step from t = 0.

    Parameters
    ----------
    model : treated (`treated`)
    y0 : (n,) consistent start
    solver : `[solver]` of a case
    treatment : the one that the model was prepared for; of `solver` by default
    fixed_step : [s], without error control (benchmarks)
    functions : of sampled states (dynamics/auxiliary.py)

    Raises
    ------
    InputError
        An integrator that has no place for the auxiliary states of the model, or for the reactions
        that its forces read.
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
    if model.quantities.reaction_kind.size and kind.takes == "constrained":
        raise InputError(
            f'solver.integrator = "{solver.integrator}": does not know the reactions that friction '
            "by a coefficient depends on; expected radau, generalized-alpha, rk8 ..."
        )
    jumps = (model.quantities.period > 0.0).any() or model.quantities.event_state.size
    if jumps and not kind.samples:
        able = [name for name, other in INTEGRATORS.items() if other.samples]
        raise InputError(
            f'solver.integrator = "{solver.integrator}": does not stop at the instants of '
            f"impacts, or of controllers with a sample_time; expected {' or '.join(able)}"
        )
    rtol = kind.local_share * solver.rtol
    options: dict[str, Any] = {
        "rtol": rtol,
        "atol": tolerances(model, y0, solver, rtol),
        "block_starts": blocks(model),
    }
    found = breaks(model, solver.t_end)
    options |= {"kinks": np.union1d(found.kinks, found.narrow), "jumps": found.jumps}
    if kind.takes == "model":
        options["sharp"] = found.kinks
    if fixed_step is not None:
        options["fixed_step"] = fixed_step
    elif solver.max_step is not None:
        options["max_step"] = solver.max_step
    else:
        options["max_step"] = found.longest
    if functions:
        options["functions"] = functions
    options |= {key.name: getattr(solver, key.name) for key in kind.keys}
    options |= kind.for_treatment(treatment.name)
    if kind.takes == "derivative" and treatment.name == "projection" and model.n_constraint:
        options["project"] = projection(model)
    subject = {
        "model": lambda: model,
        "constrained": lambda: constrained_system(model),
        "derivative": lambda: right_hand_side(model),
    }[kind.takes]()
    made: Integrator = kind(subject, 0.0, y0, solver.t_end, **options)
    made.vibrates = bool(
        model.n_mode.any() or model.plan.element_row.size or (model.quantities.along >= 0).any()
    )
    return made
