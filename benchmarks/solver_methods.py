"""Integrators and options that the solver's benchmarks compare: a new one is a line here."""

from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

from ida_integrator import SundialsIda
from scipy_integrators import SCIPY

from plymotion.solver.integrators.table import INTEGRATORS

PEERS = SCIPY | {SundialsIda.name: SundialsIda}
INTEGRATORS.update(PEERS)  # found by name as those of a case are

EXPLICIT = (1e-3, 1e-5, 1e-7)  # where stability sets the step, all cost the same
FIFTH_ORDER = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7, 2e-7, 1e-7)
SECOND_ORDER = (1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6, 1e-7)
IMPLICIT = (1e-3, 1e-4, 1e-5, 1e-6)  # in Python, or of others


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
    Method("radau", "radau", "projection", FIFTH_ORDER),
    Method("generalized-alpha", "generalized-alpha", "ggl", SECOND_ORDER),
    Method("gear", "gear", "projection", IMPLICIT, {"max_order": 5}),
    Method("gear, order 2", "gear", "projection", IMPLICIT, {"max_order": 2}),
    Method("scipy-dop853", "scipy-dop853", "projection", EXPLICIT, foreign=True),
    Method("scipy-radau", "scipy-radau", "projection", IMPLICIT, foreign=True),
    Method("scipy-bdf", "scipy-bdf", "projection", IMPLICIT, foreign=True),
    Method("scipy-lsoda", "scipy-lsoda", "projection", IMPLICIT, foreign=True),
    Method("ida", "ida", "ggl", IMPLICIT, foreign=True),
)
DEFAULT = next(m for m in INTEGRATOR_METHODS if m.integrator == "radau")
FEEDBACK = {"alpha": 50.0, "beta": 50.0}
PAIRS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
TREATMENT_METHODS = (
    Method("radau, projection", "radau", "projection", PAIRS),
    Method("radau, index1", "radau", "index1", PAIRS),
    Method("radau, baumgarte 5/5", "radau", "baumgarte", PAIRS),
    Method("radau, baumgarte 50/50", "radau", "baumgarte", PAIRS, FEEDBACK),
    # of radau the augmented Lagrangian changes Newton's matrix only, not the motion
    Method("rk8, projection", "rk8", "projection", EXPLICIT),
    Method("rk8, index1", "rk8", "index1", EXPLICIT),
    Method("rk8, baumgarte 50/50", "rk8", "baumgarte", EXPLICIT, FEEDBACK),
    Method("rk8, augmented-lagrangian", "rk8", "augmented-lagrangian", EXPLICIT),
    Method("generalized-alpha, ggl", "generalized-alpha", "ggl", SECOND_ORDER),
    Method("generalized-alpha, index3", "generalized-alpha", "index3", SECOND_ORDER),
)
# At a fixed step; all see the same highest mode, far beyond what an explicit step bears.
CHAIN_METHODS = (
    Method("generalized-alpha ggl", "generalized-alpha", "ggl", (1e-6,)),
    Method("generalized-alpha index3", "generalized-alpha", "index3", (1e-6,)),
    Method("radau", "radau", "projection", (1e-6,)),
)


def available(methods: tuple[Method, ...]) -> list[Method]:
    """Those whose integrator this version has; without scikit-sundae all but `ida`."""
    known = set(INTEGRATORS)
    if find_spec("sksundae") is None:
        known.discard("ida")
    return [m for m in methods if m.integrator in known]
