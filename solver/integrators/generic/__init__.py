"""Integrators of y' = f(t, y) behind one contract; none of them knows a body."""

from . import advice
from .base import Counters, Integrator
from .drive import Solution, integrate
from .explicit import RungeKutta5, RungeKutta8
from .gear import Gear
from .steps import Steps, StopRequest, Watch
from .table import INTEGRATORS, new_integrator

__all__ = [
    "INTEGRATORS",
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
    "new_integrator",
]
