"""Integrators by name, without a case or a mechanism."""

from typing import Any

from plymotion.solver.integrators.generic.base import Derivative, Integrator
from plymotion.solver.integrators.table import FOR_EQUATIONS
from plymotion.solver.math.arrays import Array


def new_integrator(
    name: str, f: Derivative, t0: float, y0: Array, t_end: float, **options: Any
) -> Integrator:
    """Integrator of y' = f(t, y), ready to step."""
    return FOR_EQUATIONS[name](f, t0, y0, t_end, **options)
