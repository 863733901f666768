"""Treatments of the constraints: parameters and compatible integrators."""

from dataclasses import dataclass
from typing import Any

from ...errors import InputError, did_you_mean
from ..model import Model

IMPLICIT = ("ggl", "index3")  # solved within the step, only by these integrators
SOLVE_WITH_STEP = {"generalized-alpha": IMPLICIT, "ida": ("ggl",)}
# In the order of docs/constraints.md.
TREATMENTS = ("index1", "baumgarte", "augmented-lagrangian", "projection", *IMPLICIT)
# The others divide by a singular value that is zero there.
PASSES_SINGULAR = ("augmented-lagrangian", "projection", *IMPLICIT)


@dataclass(frozen=True)
class Treatment:
    """Name and parameters; those of other treatments have no effect."""

    name: str = "projection"
    alpha: float = 5.0  # Baumgarte                            [1/s]
    beta: float = 5.0  # Baumgarte                             [1/s]
    penalty: float = 1e7  # augmented Lagrangian, relative to the effective mass of a row [-]
    frequency: float = 30.0  # augmented Lagrangian: W         [1/s]
    ratio: float = 1.0  # augmented Lagrangian: xi             [-]
    multiplier_tolerance: float = 1e-12  # of the iteration, relative
    multiplier_iterations: int = 20
    spectral_radius: float = 0.8  # of generalized-alpha at infinity


def treatment_of(solver: dict[str, Any]) -> Treatment:
    """Read the treatment from the solver table of a case; missing keys have defaults.

    Raises
    ------
    InputError
        Unknown treatment, or one that the integrator does not support.
    """
    name = solver.get("constraints", Treatment.name)
    if name not in TREATMENTS:
        raise InputError(
            f'solver.constraints = "{name}": expected one of {", ".join(TREATMENTS)}'
            f"{did_you_mean(name, TREATMENTS)}"
        )
    integrator = solver["integrator"]
    possible = SOLVE_WITH_STEP.get(integrator, tuple(t for t in TREATMENTS if t not in IMPLICIT))
    if name not in possible:
        able = [key for key, names in SOLVE_WITH_STEP.items() if name in names]
        wanted = (
            "integrator = " + " or ".join(f'"{key}"' for key in able)
            if name in IMPLICIT
            else "one that does not solve the constraints within the step (rk8, gear, rk5 ...)"
        )
        raise InputError(
            f'solver.constraints = "{name}" with integrator = "{integrator}": expected {wanted}, '
            f"or constraints = {' or '.join(possible)}"
        )
    values = {key: solver[key] for key in Treatment.__dataclass_fields__ if key in solver}
    return Treatment(**values | {"name": name})


def treated(model: Model, treatment: Treatment) -> Model:
    """Return the model with the parameters of a treatment."""
    alpha = beta = penalty = 0.0
    if treatment.name == "baumgarte":
        alpha, beta = treatment.alpha, treatment.beta
    elif treatment.name == "augmented-lagrangian":
        alpha, beta = treatment.ratio * treatment.frequency, treatment.frequency
        penalty = treatment.penalty
    elif treatment.name == "projection":
        # The same solution, which handles singular positions, without feedback.
        penalty = treatment.penalty
    return model._replace(
        alpha=float(alpha),
        beta=float(beta),
        penalty=float(penalty),
        multiplier_tolerance=float(treatment.multiplier_tolerance),
        multiplier_iterations=int(treatment.multiplier_iterations),
    )
