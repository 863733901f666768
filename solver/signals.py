"""Signals: what the user asked to measure, from states at the output times."""

from typing import Any

import numpy as np

from .bodies.marker import marker_motion
from .mechanism import BuiltMechanism
from .package.schema import Array

_AXES = {"x": 0, "y": 1, "z": 2}
_UNITS = {"position": "m", "velocity": "m/s", "deflection": "m", "rotation": "rad"}


def unit(table: dict[str, Any]) -> str:
    """Return the unit of a signal; "-" for a quotient."""
    return "-" if table["divide_by"] else _UNITS[table["kind"]]


def evaluate(built: BuiltMechanism, name: str, table: dict[str, Any], y: Array) -> Array:
    """Return the values (k,) of one signal at states y (k, n)."""
    axis = _AXES[table["component"]]
    marker = built.signal_marker[name]
    if table["kind"] in ("position", "velocity"):
        motions = [marker_motion(built.model, marker, state) for state in y]
        values = np.array([(m.x if table["kind"] == "position" else m.v)[axis] for m in motions])
    else:
        body, interface = built.places[table["at"]]
        shapes = interface.phi_B if table["kind"] == "deflection" else interface.psi_B
        a = int(built.model.pos_start[body]) + 7
        q = y[:, a : a + int(built.model.n_mode[body])]
        values = q @ shapes[axis]
    return values / (table["divide_by"] or 1.0)
