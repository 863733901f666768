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
AT_ONCE = 2**14  # stresses, so that what the criteria compute stays in the cache


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
    kept = [own[:1]]
    for strength in dict.fromkeys(points.strengths.values()):
        plies = [ply for ply, each in points.strengths.items() if each == strength]
        rows = own[np.isin(points.ply[own], plies)]
        unit = np.moveaxis(points.stress_M[rows], 2, 0).reshape(sample.shape[1], -1)
        step = max(1, AT_ONCE // len(rows))
        for first in range(0, len(sample), step):
            stress = (sample[first : first + step] @ unit).reshape(-1, len(rows), 6)
            for criterion in criteria_of(strength):
                exposure = criterion.assess(stress, strength).exposure
                kept.append(rows[np.argmax(exposure, axis=1)])
    return np.unique(np.concatenate(kept))
