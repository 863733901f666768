"""Integrators of y' = f(t, y) behind one contract; none of them knows a body."""

from inspect import signature
from typing import Any

from ...errors import did_you_mean
from ...math.arrays import Array
from . import advice
from .base import Counters, Derivative, Integrator
from .constrained import ConstrainedSystem
from .drive import Solution, integrate
from .explicit import RungeKutta5, RungeKutta8
from .gear import Gear
from .scipy_peers import ScipyBdf, ScipyDop853, ScipyLsoda, ScipyRadau
from .steps import Steps, StopRequest, Watch
from .sundials_ida import SundialsIda

INTEGRATORS: dict[str, type[Integrator]] = {
    "gear": Gear,
    "rk8": RungeKutta8,
    "rk5": RungeKutta5,
    # codes of others, for comparison
    "scipy-bdf": ScipyBdf,
    "scipy-radau": ScipyRadau,
    "scipy-lsoda": ScipyLsoda,
    "scipy-dop853": ScipyDop853,
}
# These see mass, forces and constraints of a mechanism, not its derivative alone.
CONSTRAINED: dict[str, type[Any]] = {"ida": SundialsIda}


def new_integrator(
    name: str, f: Derivative, t0: float, y0: Array, t_end: float, **options: Any
) -> Integrator:
    """Make an integrator of y' = f(t, y) by name, ready to step.

    Raises
    ------
    ValueError : unknown name or option, with the nearest known one
    """
    kind = _named(name, INTEGRATORS, options)
    return kind(f, t0, y0, t_end, **options)


def new_constrained_integrator(
    name: str, system: ConstrainedSystem, t0: float, y0: Array, t_end: float, **options: Any
) -> Integrator:
    """Make an integrator of a constrained system by name, ready to step.

    Raises
    ------
    ValueError : unknown name or option, with the nearest known one
    """
    kind = _named(name, CONSTRAINED, options)
    made: Integrator = kind(system, t0, y0, t_end, **options)
    return made


def _named(name: str, kinds: dict[str, Any], options: dict[str, Any]) -> Any:
    if name not in kinds:
        raise ValueError(f"integrator: {_unknown(name, list(kinds))}")
    kind = kinds[name]
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
    return kind


def _unknown(word: str, known: list[str]) -> str:
    return f"expected one of {', '.join(known)}, got {word!r}{did_you_mean(word, known)}"


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
