"""Kane, Ryan and Banerjee's manoeuvre: a slender beam turned from rest to 6 rad/s in 15 s."""

import numpy as np
from samples.segment_samples import cantilever

from plymotion.preprocess.beam.line import SectionMass

E, A, I2, I3 = 70e9, 4e-4, 2e-7, 2e-7  # I2 as I3: the motion is plane
GA = 5.0 / 6.0 * E / 2.6 * A
matrices = (
    np.diag([E * A, GA, GA, E / 2.6 * (I2 + I3), E * I2, E * I3]),
    SectionMass(1.2, np.zeros(3), 3000.0 * np.diag([I2 + I3, I2, I3])).matrix(),
)
beam = {"EA": E * A, "EI": E * I3, "GA": GA, "mass": 1.2, "rotary": 3000.0 * I3, "length": 10.0}
beam |= {"start": [0.0] * 3, "angle": 0.0, "spin_up": {"speed": 6.0, "duration": 15.0}}


def table(segments: int) -> dict:
    """The case; the hub turns by a sine ramp."""
    found = cantilever(segments, 10.0)
    ramp = {"ramp": {"speed": 6.0, "duration": 15.0, "shape": "sine"}}
    hub = {"kind": "revolute", "between": ["ground.wall", "beam.root"], "axis": [0.0, 0.0, 1.0]}
    found["joints"] = {"hub": hub | {"drive": ramp}}
    found["signals"] = {
        axis: {"kind": "position", "at": "beam.tip", "component": axis} for axis in "xyz"
    }
    return found
