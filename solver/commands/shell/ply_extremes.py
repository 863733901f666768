"""The highest stresses and the least strength ratio of every ply of a laminate, over its cells."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...math.arrays import Array, IntArray
from ...package.common.strengths import PlyStrength, YieldStrength
from ...strength import criteria_of

LEVELS = ("bottom", "middle", "top")


@dataclass(frozen=True)
class Reserve:
    """Load factor at which a criterion predicts failure, and the position of the failure."""

    ratio: float  # strength ratio R; margin of safety R - 1    [-]
    criterion: str
    mode: str
    cell: int
    level: str  # of the ply, one of LEVELS


@dataclass(frozen=True)
class PlyExtreme:
    """One ply under one load case, over all cells of its laminate."""

    ply: int  # from 0, the bottom one
    material: str
    angle_deg: float
    stress_M: Array  # (6,) of largest size, with sign: 11, 22, 33, 23, 13, 12 [Pa]
    cells: IntArray  # (6,) where
    reserves: tuple[Reserve, ...]  # one for each criterion; none without strengths


def ply_extremes(
    materials: Sequence[str],
    angles_deg: Sequence[float],
    operators: Array,
    resultants: Array,
    cells: IntArray,
    strengths: Mapping[str, PlyStrength | YieldStrength],
) -> list[PlyExtreme]:
    """Extremes of all plies of a laminate, bottom one first.

    Parameters
    ----------
    materials, angles_deg : of the k plies
    operators : (k, 3, 6, 8) stress in ply axes per unit resultant at bottom, middle, top
    resultants : (c, 8) N [N/m], M [N], T [N/m] of the cells in laminate axes
    cells : (c,) number of each cell, at least one
    strengths : of those materials that have some
    """
    found = []
    for ply, (material, angle) in enumerate(zip(materials, angles_deg, strict=True)):
        stress = np.einsum("lij,cj->cli", operators[ply], resultants, optimize=True)
        flat = stress.reshape(-1, 6)
        largest = np.argmax(np.abs(flat), axis=0)
        reserves = []
        if material in strengths:
            strength = strengths[material]
            for criterion in criteria_of(strength):
                verdict = criterion.assess(flat, strength)
                worst = int(np.argmax(verdict.exposure))
                reserves.append(
                    Reserve(
                        float(verdict.ratio[worst]),
                        criterion.name,
                        verdict.modes[int(verdict.mode[worst])],
                        int(cells[worst // len(LEVELS)]),
                        LEVELS[worst % len(LEVELS)],
                    )
                )
        found.append(
            PlyExtreme(
                ply,
                material,
                float(angle),
                flat[largest, np.arange(6)],
                np.asarray(cells[largest // len(LEVELS)]),
                tuple(reserves),
            )
        )
    return found
