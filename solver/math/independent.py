"""Changes of arrays of which all others are combinations.

Many plies change the stiffness of a section in few ways, and with it all arrays of a body.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg import qr

from .arrays import Array


def independent(
    values: Mapping[Any, Any], changes: Sequence[Mapping[Any, Array]], same: float
) -> tuple[list[int], Array]:
    """Return which changes (r) all others are made of, and shares (r, P) of them in the P given.

    Parameters
    ----------
    values : the arrays that change, by name
    changes : of some of these arrays
    same : of the largest change, each relative to its own arrays: below it there is none
    """
    sizes = {
        n: np.abs(values[n]).max(initial=0.0) or 1.0
        for n in dict.fromkeys(n for c in changes for n in c)
    }
    if not sizes:
        return [], np.zeros((0, len(changes)))
    zeros = {n: np.zeros(np.shape(values[n])) for n in sizes}
    rows = np.array(
        [np.hstack([np.ravel(c.get(n, zeros[n])) / s for n, s in sizes.items()]) for c in changes]
    )
    norms = np.linalg.norm(rows, axis=1)
    norms[norms == 0.0] = 1.0
    R, order = qr((rows / norms[:, None]).T, mode="r", pivoting=True)
    r = int((np.abs(np.diag(R)) > same * abs(R[0, 0])).sum())
    shares = np.zeros((len(rows), len(rows)))
    shares[np.ix_(order[:r], order)] = np.linalg.solve(R[:r, :r], R[:r])
    kept = np.sort(order[:r])
    return kept.tolist(), shares[kept] * norms / norms[kept, None]
