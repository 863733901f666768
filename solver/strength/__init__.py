"""Failure criteria of plies and metals on stresses in material axes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..math.arrays import Array
from ..package.common.strengths import PlyStrength, YieldStrength
from .hashin import hashin, hashin_bound
from .max_stress import max_stress
from .ray import Verdict
from .tsai_hill import tsai_hill, tsai_hill_bound
from .tsai_wu import tsai_wu
from .von_mises import von_mises

__all__ = [
    "PLY_CRITERIA",
    "YIELD_CRITERIA",
    "Criterion",
    "Verdict",
    "criteria_of",
    "hashin",
    "max_stress",
    "tsai_hill",
    "tsai_wu",
    "von_mises",
]


@dataclass(frozen=True)
class Criterion:
    """A criterion by name.

    `bound` is a convex function of the stress, proportional to it and never below the exposure.
    With it the search over a history skips most points and times (search.py).
    """

    name: str
    assess: Callable[[Array, Any], Verdict]
    bound: Callable[[Array, Any], Array]


def _convex(name: str, assess: Callable[[Array, Any], Verdict]) -> Criterion:
    """A criterion with a convex failure surface: its exposure is its own bound."""
    return Criterion(name, assess, lambda stress, strength: assess(stress, strength).exposure)


PLY_CRITERIA = (
    _convex("max-stress", max_stress),
    Criterion("tsai-hill", tsai_hill, tsai_hill_bound),
    _convex("tsai-wu", tsai_wu),
    Criterion("hashin", hashin, hashin_bound),
)
YIELD_CRITERIA = (_convex("von-mises", von_mises),)


def criteria_of(strength: PlyStrength | YieldStrength) -> tuple[Criterion, ...]:
    """The criteria that apply to a material of these strengths."""
    return PLY_CRITERIA if isinstance(strength, PlyStrength) else YIELD_CRITERIA
