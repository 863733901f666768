"""Spring and damper with given curves of their force."""

from collections.abc import Mapping
from typing import Any

from ....errors import InputError
from .contract import CoordinateForce, Curve, Number, Terms


def _terms(values: Mapping[str, Any]) -> Terms:
    if values["force_displacement"] is None and values["force_velocity"] is None:
        raise InputError(": has no effect; expected force_displacement or force_velocity")
    length = " - length" if values["length"] is not None else ""
    parts = []
    if values["force_displacement"] is not None:
        parts.append(f"-force_displacement(x{length})")
    if values["force_velocity"] is not None:
        parts.append("-force_velocity(v)")
    return Terms(" ".join(parts))


NONLINEAR_SPRING = CoordinateForce(
    kind="nonlinear_spring",
    turns=False,
    meaning="a spring and damper with given curves",
    keys=(
        Curve(
            "force_displacement",
            "N or N m",
            "force against the coordinate, over the coordinate [m or rad]",
        ),
        Curve(
            "force_velocity",
            "N or N m",
            "force against the motion, over the rate of the coordinate [m/s or rad/s]",
        ),
        Number(
            "length",
            "m or rad",
            "value of the coordinate that `force_displacement` counts from; absent: 0",
        ),
    ),
    terms=_terms,
    order=5,
)
