"""A taut beam of unit length, EI and mass on two supports, T = 1000: w^2 = EI a^4 + T a^2."""

import numpy as np
from samples.segment_samples import cantilever

from plymotion.preprocess.beam.line import SectionMass

matrices = (
    np.diag([1e11, 1e11, 1e11, 1.0, 1.0, 1.0]),
    SectionMass(1.0, np.zeros(3), np.diag([2e-12, 1e-12, 1e-12])).matrix(),
)


def table(modes: int) -> dict:
    """The case, with a number of bending modes between the supports."""
    found = cantilever(1, 1.0)
    beam = found["bodies"]["beam"]
    del beam["segments"]
    beam |= {"elements": 20, "reference": {"kind": "chord", "at": ["root", "tip"]}}
    beam["modes"] = [{"kind": "bending-xy", "count": modes}, {"kind": "static-axial"}]
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
