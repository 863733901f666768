"""Units of length, mass and time of another code, in SI."""

from typing import Literal, TypedDict

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
MASSES = {
    "kg": 1.0,
    "g": 1e-3,
    "t": 1e3,
    "lb": 0.45359237,
    "slug": 14.59390293720636,
    "slinch": 175.12683524647636,  # lbf s2/in
}
TIMES = {"s": 1.0, "ms": 1e-3}


class UnitsTable(TypedDict):
    """`units` of an import file; force and stress follow, e.g. N and MPa from mm, t, s."""

    length: Literal["m", "cm", "mm", "in", "ft"]
    mass: Literal["kg", "g", "t", "lb", "slug", "slinch"]
    time: Literal["s", "ms"]


SI: UnitsTable = {"length": "m", "mass": "kg", "time": "s"}


def sizes(units: UnitsTable) -> tuple[float, float, float]:
    """Size of the units of length, mass and time [m, kg, s]."""
    return LENGTHS[units["length"]], MASSES[units["mass"]], TIMES[units["time"]]
