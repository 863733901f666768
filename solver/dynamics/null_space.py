"""Free motions of a mechanism: the null space of its constraints, with a rank that can be judged.

Round-off in a mode shape, or in positions that joints close to 1e-12, makes rows that follow from
others look independent: their singular values are 1e-12 to 1e-8 of the largest. Counted as
independent, they lock a real motion. Hinges that are tilted on purpose give 1e-4 and more. The
rank is therefore cut at 1e-6, or at the widest gap between singular values near it.
"""

from typing import NamedTuple

import numpy as np

from ..math.arrays import Array
from .constraints.scaling import row_masses, scaled_jacobian
from .dense_equations import Equations

CUT = 1e-6  # singular values below count as zero, relative to the largest
_NEAR = (1e-9, 1e-3)  # singular values among which a gap is searched
_NOISE = 1e-16  # what a singular value of zero is computed as
_CLEAR = 1e2  # factor between the values on both sides of the cut below which it is doubtful


class Rank(NamedTuple):
    """Rank of the constraint rows, and the singular values on both sides of the cut."""

    value: int
    rows: int
    last: float  # smallest that counts, relative to the largest; 1 without rows
    first: float  # largest that does not count; 0 if all count

    @property
    def redundant(self) -> int:
        """Number of rows that follow from the others."""
        return self.rows - self.value

    @property
    def doubtful(self) -> bool:
        """Whether the cut divides values that lie close to each other."""
        return self.first > 0.0 and self.last < _CLEAR * self.first

    @property
    def text(self) -> str:
        """What to tell a user."""
        beside = f", the next {self.first:.2g}" if self.redundant else ""
        return (
            f"rank {self.value} of {self.rows} constraint rows: smallest singular value that "
            f"counts {self.last:.2g}{beside}"
        )


def rank_of(s: Array, rows: int) -> Rank:
    """Return the rank of that many rows for singular values s (k,) in descending order."""
    if s.size == 0 or s[0] == 0.0:
        return Rank(0, rows, 1.0, 0.0)
    r = s / s[0]
    value = int(np.sum(r > CUT))
    if value < r.size and r[value - 1] < _CLEAR * r[value]:
        # The cut divides values of one size: the widest gap near it decides.
        near = [k for k in range(1, r.size) if r[k] < _NEAR[1] and r[k - 1] > _NEAR[0]]
        value = max(near, key=lambda k: r[k - 1] / max(r[k], _NOISE))
    first = float(r[value]) if value < r.size else 0.0
    return Rank(value, rows, float(r[value - 1]), first)


class FreeMotions(NamedTuple):
    """Null space and pseudo-inverse of the constraint Jacobian in the metric of the inertia."""

    Z: Array  # (n_vel, n_free), Phi_q Z = 0, Z' S Z = 1
    Z_left: Array  # (n_free, n_vel) Z' S
    P: Array  # (n_vel, n_c) pseudo-inverse: Phi_q P r = r for consistent r, Z_left P = 0
    rank: Rank


def free_motions(equations: Equations, inertia_scale: Array) -> FreeMotions:
    """Return the free motions at an evaluation; `inertia_scale` (n_vel,) is S of the model."""
    Phi_q = equations.Phi_q
    root = np.sqrt(inertia_scale)
    n_c, n = Phi_q.shape
    if n_c == 0:
        return FreeMotions(
            np.diag(1.0 / root), np.diag(root), np.zeros((n, 0)), rank_of(root[:0], 0)
        )
    U, s, Vt = np.linalg.svd(scaled_jacobian(Phi_q, inertia_scale))
    rank = rank_of(s, n_c)
    k = rank.value
    lengths = np.sqrt(row_masses(Phi_q, inertia_scale))
    P = (Vt[:k].T / root[:, None]) @ (U[:, :k] / s[:k]).T * lengths
    return FreeMotions(Vt[k:].T / root[:, None], Vt[k:] * root, P, rank)
