"""A taut beam of unit length, EI and mass on two supports, T = 1000: w^2 = EI a^4 + T a^2."""

import numpy as np
from scenes import unit_beam, unit_matrices

matrices = unit_matrices(1e11, 1e-12)


def table(modes: int) -> dict:
    """The case, with a number of bending modes between the supports."""
    chord = {"kind": "chord", "at": ["root", "tip"]}
    found = unit_beam([{"kind": "bending-xy", "count": modes}], reference=chord)
    found["ground"]["end"] = {"position": [1.0, 0.0, 0.0]}
    z, x = [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]
    found["joints"] = {
        "hinge": {"kind": "revolute", "between": ["ground.wall", "beam.root"], "axis": z},
        "slide": {"kind": "point_on_line", "between": ["ground.end", "beam.tip"], "axis": x},
    }
    pull = {"kind": "force", "at": "beam.tip", "direction": x, "law": {"constant": 1000.0}}
    return found | {"forces": {"pull": pull}}


def truth(_: object) -> list[float]:
    """Angular frequencies of one and two half waves [rad/s]."""
    a = np.pi * np.array([1.0, 2.0])
    return np.sqrt(a**4 + 1000.0 * a**2).tolist()
