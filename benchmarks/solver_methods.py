"""Integrators and options that the solver's benchmarks compare: a new one is a line here."""

from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

from plymotion.solver.integrate import CONSTRAINED, INTEGRATORS

EXPLICIT = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
IMPLICIT = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
SECOND_ORDER = (1e-3, 1e-4, 1e-5, 1e-6)


@dataclass(frozen=True)
class Method:
    """An integrator with its treatment of constraints, and the tolerances it is tried at."""

    label: str
    integrator: str
    constraints: str
    rtols: tuple[float, ...]
    options: dict[str, Any] = field(default_factory=dict)
    foreign: bool = False  # of SciPy or SUNDIALS, behind our contract


INTEGRATOR_METHODS = (
    Method("rk8", "rk8", "projection", EXPLICIT),
    Method("rk5", "rk5", "projection", EXPLICIT),
    Method("radau", "radau", "projection", IMPLICIT),
    Method("generalized-alpha", "generalized-alpha", "ggl", SECOND_ORDER),
    Method("gear", "gear", "projection", SECOND_ORDER, {"max_order": 5}),
    Method("gear, order 2", "gear", "projection", SECOND_ORDER, {"max_order": 2}),
    Method("scipy-dop853", "scipy-dop853", "projection", EXPLICIT, foreign=True),
    Method("scipy-radau", "scipy-radau", "projection", SECOND_ORDER, foreign=True),
    Method("scipy-bdf", "scipy-bdf", "projection", SECOND_ORDER, foreign=True),
    Method("scipy-lsoda", "scipy-lsoda", "projection", SECOND_ORDER, foreign=True),
    Method("ida", "ida", "ggl", SECOND_ORDER, foreign=True),
)
FEEDBACK = {"alpha": 50.0, "beta": 50.0}
TREATMENT_METHODS = (
    Method("projection", "rk8", "projection", EXPLICIT),
    Method("index1", "rk8", "index1", EXPLICIT),
    Method("baumgarte 5/5", "rk8", "baumgarte", EXPLICIT),
    Method("baumgarte 50/50", "rk8", "baumgarte", EXPLICIT, FEEDBACK),
    Method("augmented-lagrangian", "rk8", "augmented-lagrangian", EXPLICIT),
    Method("ggl", "generalized-alpha", "ggl", SECOND_ORDER),
    Method("index3", "generalized-alpha", "index3", SECOND_ORDER),
)
# At a fixed step; all see the same highest mode, far beyond what an explicit step bears.
CHAIN_METHODS = (
    Method("generalized-alpha ggl", "generalized-alpha", "ggl", (1e-6,)),
    Method("generalized-alpha index3", "generalized-alpha", "index3", (1e-6,)),
    Method("radau", "radau", "projection", (1e-6,)),
)


def available(methods: tuple[Method, ...]) -> list[Method]:
    """Those whose integrator this version has; without scikit-sundae all but `ida`."""
    known = {*INTEGRATORS, *CONSTRAINED}
    if find_spec("sksundae") is None:
        known.discard("ida")
    return [m for m in methods if m.integrator in known]
