"""Keys of an input file that the file of a kind declares, as plain data."""

from dataclasses import dataclass


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
