"""What a force element must supply.

A kind of force element is one file of this folder that ends in a `ForceKind`, and one entry with
its two branches in table.py. Its keys in a case file stand in inputs/case/forces.py.

A kernel is compiled (`@jit`) and sees two markers as rows of bodies/motion.py, in global
components:

wrench(one, two, parameters, law) -> Wrench
    parameters : (N_PARAMETER,) those of `ForceKind.parameters`, in their order
    law : value of the element's law at the present time [N or N m]; 0 without one

rows(one, two, parameters, rows) -> None
    What of the element Newton's iteration of the implicit integrators must know: forces
    F = k e + c edot along some directions g, edot = g v, that act as -g' F. Fills
    rows (most_rows, N_ELEMENT_ROW):
    rows[i, :12] : g by v_1, w_1, v_2, w_2 of the two markers, as in joints/rows.py
    rows[i, FORCE] : F [N, N m]
    rows[i, STIFFNESS] : dF/de [N/m, N m/rad]; 0 or above
    rows[i, DAMPING] : dF/dedot [N s/m, N m s/rad]; 0 or above
    Forces of the wrench that are no such F are loads: right, but they cost iterations, and short
    steps where they are stiff. Below half of the true stiffness Newton's iteration diverges where
    steps do not resolve the element; above it, it is slow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ...math.triple import Triple
from ..workspace import DAMPING, FORCE, N_ELEMENT_ROW, STIFFNESS


class Wrench(NamedTuple):
    """Force and moment on marker two at its origin, global components, and their energy.

    Marker one gets the opposite force at the origin of marker two, unless the element is a load
    from outside.
    """

    force: Triple  # [N]
    moment: Triple  # [N m]
    potential: float  # energy stored in springs [J]
    power: float  # of dampers, actuators and loads, into the system [W]


def no_rows(parameters: Sequence[float]) -> list[int]:
    """Return the rows of a kind that is left out of Newton's matrix."""
    return []


@dataclass(frozen=True)
class ForceKind:
    """A kind of force element, as dynamics sees it."""

    name: str  # `kind` in a case file
    parameters: tuple[str, ...]  # names of its numbers, in SI units
    wrench: Callable[..., Any]  # kernel
    rows: Callable[..., Any] | None = None  # kernel; None: left out of Newton's matrix
    most_rows: int = 0  # that the kernel fills
    rows_in_use: Callable[[Sequence[float]], list[int]] = no_rows  # of an element, by parameters
    from_outside: bool = False  # a load: nothing acts back on marker one


__all__ = [
    "DAMPING",
    "FORCE",
    "N_ELEMENT_ROW",
    "STIFFNESS",
    "ForceKind",
    "Wrench",
    "no_rows",
]
