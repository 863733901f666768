"""Keys of an input file that the file of a kind declares, as plain data."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Number:
    """A number: a key of the case file, and an argument of what the kind supplies."""

    name: str
    unit: str
    meaning: str  # one line
    required: bool = False
    default: float | None = None  # None: the file of the kind finds it
    above: float | None = None  # bounds: above, or from `least` on; up to `most`
    least: float | None = None
    most: float | None = None
    not_zero: bool = False
    integer: bool = False


@dataclass(frozen=True)
class Three:
    """Three numbers, 0 or above, along or about the axes of marker one."""

    name: str
    unit: str
    meaning: str  # one line
    required: bool = False  # else: zeros


@dataclass(frozen=True)
class Direction:
    """A global direction at the start."""

    name: Literal["axis", "axis_1", "axis_2"]
    meaning: str  # one line
    required: bool = False  # else: global z
    absent: bool = False  # may be absent, without default


@dataclass(frozen=True)
class Expression:
    """An expression of a case (math/expressions/parse.py)."""

    name: str
    unit: str
    meaning: str  # one line
    required: bool = False
    default: str | None = None


@dataclass(frozen=True)
class Curve:
    """Points of a curve y(x)."""

    name: str
    unit: str
    meaning: str  # one line


@dataclass(frozen=True)
class OfTime:
    """The law of time of a force or torque; may be absent."""

    name: str
    meaning: str  # one line
