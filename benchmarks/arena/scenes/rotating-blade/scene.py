"""A cantilever of unit length, EI and mass per length about a hub: Bernoulli's beam, no stretch."""

import numpy as np
from samples.segment_samples import cantilever

from plymotion.preprocess.beam.line import SectionMass

matrices = (
    np.diag([1e8, 1e8, 1e8, 1.0, 1.0, 1.0]),
    SectionMass(1.0, np.zeros(3), np.diag([2e-10, 1e-10, 1e-10])).matrix(),
)


def table(modes: int) -> dict:
    """The case, with a number of flap modes."""
    found = cantilever(1, 1.0)
    beam = found["bodies"]["beam"]
    del beam["segments"]
    beam |= {"elements": 20, "x2_axis": [0.0, 1.0, 0.0]}
    beam["modes"] = [{"kind": "bending-xz", "count": modes}, {"kind": "static-axial"}]
    hub = {"kind": "revolute", "between": ["ground.wall", "beam.root"], "axis": [0.0, 0.0, 1.0]}
    found["joints"] = {"hub": hub | {"drive": {"speed": 6.0}}}
    return found
