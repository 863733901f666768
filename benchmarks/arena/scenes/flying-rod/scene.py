"""Simo and Vu-Quoc's free rod, 10 m: 8 N and 80 N m at its lower end until 2.5 s."""

import numpy as np

from plymotion.preprocess.beam.line import SectionMass

EA, EI, LENGTH, FORCE, MOMENT = 1e4, 100.0, 10.0, 8.0, -80.0
matrices = (
    np.diag([EA, EA, EA, 100.0 * EI, 100.0 * EI, EI]),
    SectionMass(1.0, np.zeros(3), 10.0 * np.diag([2, 1, 1])).matrix(),
)
START, ANGLE = [6.0, 0.0, 0.0], np.pi - np.arctan(4.0 / 3.0)
beam = {"EA": EA, "EI": EI, "GA": EA, "mass": 1.0, "rotary": 10.0, "length": LENGTH}
beam |= {"start": START, "angle": ANGLE, "force": [FORCE, 0.0, 0.0], "moment": MOMENT}


def table(segments: int) -> dict:
    """The case; the mean frame in the middle of the rod."""
    body = {
        "kind": "beam",
        "length": LENGTH,
        "section": "s",
        "material": "m",
        "elements": 4 * segments,
        "segments": segments,
        "position": START,
        "rotation_deg": [0.0, 0.0, float(np.degrees(ANGLE))],
        "interfaces": {"low": {"at": "start"}, "mid": {"at": 0.5}, "high": {"at": "end"}},
        "reference": {"kind": "clamped", "at": "mid"},
    }
    place = {"at": "beam.low"}
    force = {"kind": "force", "direction": [1.0, 0.0, 0.0], "law": {"constant": FORCE}}
    torque = {"kind": "torque", "direction": [0.0, 0.0, 1.0], "law": {"constant": MOMENT}}
    return {
        "bodies": {"beam": body},
        "forces": {"force": place | force, "torque": place | torque},
        "signals": {
            axis: {"kind": "position", "at": "beam.high", "component": axis} for axis in "xyz"
        },
        "solver": {"t_end": 2.5, "output_step": 0.1, "geometric_stiffening": True},
    }
