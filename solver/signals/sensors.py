"""Sensors of a mechanism, created before the run so that errors are reported early."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..mechanism import BuiltMechanism
from .joints import joint_coordinate, reaction
from .points import POINT_UNITS, point_values
from .recording import Recording
from .sections import ply_stress_values, resultant_values

Values = Callable[[Recording], Array]
_AXES = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True)
class Sensor:
    """One signal: unit ("-" for a quotient), description, and function for its values (k,)."""

    unit: str
    description: str
    values: Values


def sensors(built: BuiltMechanism, tables: dict[str, dict[str, Any]]) -> dict[str, Sensor]:
    """Return the sensors of the signals of a case, as plain data (inputs/case/signals.py).

    Raises
    ------
    InputError
        A package without resultants or stresses, an unknown ply.
    """
    found = {}
    for name, table in tables.items():
        unit, values = _measuring(built, name, table)
        divisor = table["divide_by"]
        if divisor is not None:
            unit, values = "-", _divided(values, float(divisor))
        found[name] = Sensor(unit, table["description"], values)
    return found


def _measuring(built: BuiltMechanism, name: str, table: dict[str, Any]) -> tuple[str, Values]:
    kind = table["kind"]
    if kind in POINT_UNITS:
        vectors = point_values(built, name, table)
        return POINT_UNITS[kind], _component(vectors, table["component"])
    if kind == "joint":
        coordinate = table["coordinate"]
        values = joint_coordinate(built.joints[table["joint"]], coordinate)
        return "rad" if coordinate.startswith("angle") else "m", values
    if kind == "reaction":
        vectors = reaction(built.joints[table["joint"]], table)
        unit = "N" if table["quantity"] == "force" else "N m"
        return unit, _component(vectors, table["component"])
    body = built.body_names.index(table["body"])
    package = built.packages[table["body"]]
    if kind == "resultant":
        unit = "N" if table["component"].startswith("F") else "N m"
        return unit, resultant_values(f"signals.{name}", body, package, table)
    return "Pa", ply_stress_values(f"signals.{name}", body, package, table)


def _component(vectors: Values, component: str) -> Values:
    if component == "magnitude":
        return lambda recording: np.asarray(np.linalg.norm(vectors(recording), axis=1))
    axis = _AXES[component]
    return lambda recording: vectors(recording)[:, axis]


def _divided(values: Values, by: float) -> Values:
    return lambda recording: values(recording) / by
