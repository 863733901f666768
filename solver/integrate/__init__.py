"""Integrators of y' = f(t, y) behind one contract; none of them knows a body."""

from inspect import signature
from typing import Any

from ..errors import did_you_mean
from .base import Counters, Derivative, Integrator
from .drive import Solution, StopRequest, integrate
from .explicit import RungeKutta5, RungeKutta8
from .gear import Gear
from .norm import Array

INTEGRATORS: dict[str, type[Integrator]] = {"gear": Gear, "rk8": RungeKutta8, "rk5": RungeKutta5}


def new_integrator(
    name: str, f: Derivative, t0: float, y0: Array, t_end: float, **options: Any
) -> Integrator:
    """Make an integrator by name, ready to step.

    Raises
    ------
    ValueError : unknown name or option, with the nearest known one
    """
    if name not in INTEGRATORS:
        raise ValueError(f"integrator: {_unknown(name, list(INTEGRATORS))}")
    kind = INTEGRATORS[name]
    known = [
        p.name
        for c in kind.__mro__
        if "__init__" in vars(c)
        for p in signature(vars(c)["__init__"]).parameters.values()
        if p.kind is p.KEYWORD_ONLY
    ]
    for option in options:
        if option not in known:
            raise ValueError(f"integrator {name}, option: {_unknown(option, known)}")
    return kind(f, t0, y0, t_end, **options)


def _unknown(word: str, known: list[str]) -> str:
    return f"expected one of {', '.join(known)}, got {word!r}{did_you_mean(word, known)}"


__all__ = [
    "INTEGRATORS",
    "Counters",
    "Gear",
    "Integrator",
    "RungeKutta5",
    "RungeKutta8",
    "Solution",
    "StopRequest",
    "integrate",
    "new_integrator",
]
