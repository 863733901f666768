"""The few points of a section that govern its strength in a run.

A picture that evaluates the strength ratio of a section at every time needs the points with the
highest exposure only. They are found from a sample of the resultants of the run.
"""

from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray
from ..package.common.strengths import PlyStrength, YieldStrength
from . import criteria_of

SAMPLES = 240  # resultants that the points are chosen from
FEW = 24  # points that are all kept


class Points(NamedTuple):
    """Points of one section or laminate: stresses per unit resultant, ply, strength of it."""

    stress_M: Array  # (p, 6, j)
    ply: IntArray  # (p,)
    strengths: dict[int, PlyStrength | YieldStrength]  # by ply


def governing_points(points: Points, F: Array) -> IntArray:
    """Rows of the points that have the highest exposure of any criterion under some resultants.

    F : (t, j) resultants
    """
    there = np.array([ply in points.strengths for ply in points.ply.tolist()], dtype=bool)
    own = np.flatnonzero(there)
    if len(own) <= FEW or not len(F):
        return own
    sample = F[np.unique(np.linspace(0, len(F) - 1, SAMPLES).round().astype(int))]
    sample = sample[np.abs(sample).max(axis=1) > 0.0]
    stress = np.einsum("pij,tj->tpi", points.stress_M[own], sample, optimize=True)
    kept = [own[:1]]
    for strength in dict.fromkeys(points.strengths.values()):
        plies = [ply for ply, each in points.strengths.items() if each == strength]
        rows = np.flatnonzero(np.isin(points.ply[own], plies))
        for criterion in criteria_of(strength) if len(sample) else ():
            exposure = criterion.assess(stress[:, rows], strength).exposure
            kept.append(own[rows[np.argmax(exposure, axis=1)]])
    return np.unique(np.concatenate(kept))
