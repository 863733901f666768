"""Changes of arrays of which all others are combinations.

Many plies change the stiffness of a section in few ways, and with it all arrays of a body.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg import qr

from .arrays import Array


def independent(
    values: Mapping[Any, Any],
    changes: Sequence[Mapping[Any, Array]],
    same: float,
    apart: Collection[int] = (),
) -> tuple[list[int], Array]:
    """Return which changes (r) all others are made of, and shares (r, P) of them in the P given.

    Parameters
    ----------
    values : the arrays that change, by name
    changes : of some of these arrays
    same : of the largest change, each relative to its own arrays: below it there is none
    apart : numbers of changes that are kept and are no part of others
    """
    among = [k for k in range(len(changes)) if k not in apart]
    sizes = {
        n: np.abs(values[n]).max(initial=0.0) or 1.0
        for n in dict.fromkeys(n for k in among for n in changes[k])
    }
    shares = np.zeros((len(changes), len(changes)))
    shares[[*apart], [*apart]] = 1.0
    if not sizes:
        return sorted(apart), shares[sorted(apart)]
    zeros = {n: np.zeros(np.shape(values[n])) for n in sizes}
    rows = np.array(
        [
            np.hstack([np.ravel(changes[k].get(n, zeros[n])) / s for n, s in sizes.items()])
            for k in among
        ]
    )
    norms = np.linalg.norm(rows, axis=1)
    norms[norms == 0.0] = 1.0
    R, order = qr((rows / norms[:, None]).T, mode="r", pivoting=True)
    r = int((np.abs(np.diag(R)) > same * abs(R[0, 0])).sum())
    own, first = np.array(among)[order], order[:r]
    parts = np.linalg.solve(R[:r, :r], R[:r]) * norms[order] / norms[first, None]
    shares[np.ix_(own[:r], own)] = parts
    kept = sorted([*apart, *own[:r].tolist()])
    return kept, shares[kept]
