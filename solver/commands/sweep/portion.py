"""A portion of the members of a sweep: what a worker computes at a time."""

import platform
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from ...errors import InputError
from ...inputs.case.sources import solver_sha256
from .member import Packages, Row, compute
from .plan import Member, Plan, read_plan

_ALONE = threading.Lock()  # workers of dask may have several threads; integrators share memory


@dataclass(frozen=True)
class Order:
    """What all portions of a sweep have in common."""

    file: Path  # the sweep file, under the same name for all workers
    content: str  # digest of the sweep and its packages: another one is read again
    solver: str  # digest of the solver's sources
    allow_doubtful: bool


def compute_portion(
    order: Order, members: Sequence[Member], keys: Sequence[str]
) -> tuple[list[Row], float]:
    """Return the rows of some members and the time that they took [s].

    Rows that an interruption left without an end are pending.

    Raises
    ------
    InputError
        The sweep file cannot be read here, or the sources of this worker are others.
    """
    begin = time.perf_counter()
    if solver_sha256() != order.solver:
        raise InputError(
            f"{platform.node()}: the worker has other sources of Plymotion than the command: "
            "restart the workers"
        )
    with _ALONE:
        plan, packages = _read(order)
        rows = compute(plan.part(members), packages, range(len(members)), keys)
    return rows, time.perf_counter() - begin


@lru_cache(maxsize=1)
def _read(order: Order) -> tuple[Plan, Packages]:
    plan = read_plan(order.file, allow_doubtful=order.allow_doubtful)
    return plan, Packages(plan)
