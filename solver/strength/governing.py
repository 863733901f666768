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


def governing_points(points: Points, resultants_E: Array, q: Array) -> IntArray:
    """Rows of the points that have the highest exposure of any criterion at some site and time.

    Parameters
    ----------
    resultants_E : (s, j, m) per unit mode, of the sites that have these points
    q : (t, m) modal coordinates
    """
    own = np.flatnonzero(np.isin(points.ply, list(points.strengths)))
    count = len(q) * len(resultants_E)
    if len(own) <= FEW or not count:
        return own
    chosen = np.unique(np.linspace(0, count - 1, SAMPLES).round().astype(int))
    time, site = np.divmod(chosen, len(resultants_E))
    sample = np.einsum("njm,nm->nj", resultants_E[site], q[time])
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
