"""Names, directions and signs of modes.

An eigensolver does not determine the sign of a mode and, for equal frequencies, the basis of
their space. Both are fixed here, so that repeated builds give the same package:

- modes of equal frequency (a square section has equal bending modes in any plane) are rotated so
  that their motion separates into the body's directions, bending-xy first, then bending-xz,
  torsion, axial; - nodes are searched from the farthest from the reference node towards it. The
  first node that moves by at least half of the largest motion moves in the positive direction (of
  the component that names the mode: y, z, rotation x, x).
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import scipy.linalg

from ...solver.math.arrays import Array, IntArray

# Component (of ux uy uz rx ry rz) that determines name and sign of the mode.
COMPONENTS = {"bending-xy": 1, "bending-xz": 2, "torsion": 3, "axial": 0}
KINDS = tuple(COMPONENTS)

COINCIDENT = 1e-8  # relative distance below which eigenvalues are treated as equal
TIE = 1e-6  # shares of mass or work closer than this count as equal: the first kind or load is used

# columns (n_dof, m) -> (4, m, m): modal mass split over KINDS
Participation = Callable[[Array], Array]


def clusters(values: Array) -> list[tuple[int, int]]:
    """Ranges (first, end) of equal values in ascending eigenvalues."""
    if not len(values):
        return []
    breaks = np.nonzero(np.diff(values) > COINCIDENT * np.abs(values[1:]))[0] + 1
    return list(pairwise([0, *breaks.tolist(), len(values)]))


def separating_rotation(values: Array, P: Array) -> Array:
    """Rotation (m, m) of modes that aligns those of equal frequency with the body's directions.

    Parameters
    ----------
    values : (m,) ascending eigenvalues
    P : (4, m, m) modal mass by KINDS
    """
    rank = np.arange(len(KINDS), 0, -1.0)  # distinct weights separate all kinds in one step
    turn = np.eye(len(values))
    for first, end in clusters(values):
        if end - first > 1:
            part = slice(first, end)
            weighted = np.einsum("k,kij->ij", rank, P[:, part, part])
            turn[part, part] = scipy.linalg.eigh(weighted)[1][:, ::-1]
    return turn


def shares_of(P: Array) -> Array:
    """Share (m, 4) of each mode's mass that moves in each of KINDS, from the split (4, m, m)."""
    return np.asarray(np.einsum("kii->ik", P) / np.einsum("kii->i", P)[:, None])


def kind_of(share: Array) -> str:
    """Kind of the largest share."""
    return KINDS[int(np.argmax(share >= share.max() - TIE))]


def signs(columns: Array, kinds: list[str], far_to_near: IntArray) -> Array:
    """+1 or -1 for every column, by the rule at the top of this file."""
    found = np.ones(len(kinds))
    for i, kind in enumerate(kinds):
        motion = columns[COMPONENTS[kind] :: 6, i][far_to_near]
        first = int(np.argmax(np.abs(motion) >= 0.5 * np.abs(motion).max()))
        found[i] = 1.0 if motion[first] > 0.0 else -1.0
    return found
