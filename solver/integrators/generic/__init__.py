"""Integrators of y' = f(t, y) behind one contract; none of them knows a body."""

from . import advice
from .base import Counters, Integrator
from .constrained import ConstrainedSystem
from .drive import Solution, integrate
from .explicit import RungeKutta5, RungeKutta8
from .gear import Gear
from .steps import Steps, StopRequest, Watch
from .table import CONSTRAINED, INTEGRATORS, new_constrained_integrator, new_integrator

__all__ = [
    "CONSTRAINED",
    "INTEGRATORS",
    "ConstrainedSystem",
    "Counters",
    "Gear",
    "Integrator",
    "RungeKutta5",
    "RungeKutta8",
    "Solution",
    "Steps",
    "StopRequest",
    "Watch",
    "advice",
    "integrate",
    "new_constrained_integrator",
    "new_integrator",
]
