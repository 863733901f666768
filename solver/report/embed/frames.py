"""Times of the animation, and the ranges of its colours over all output times."""

import numpy as np

from ...math.arrays import Array, IntArray
from ...results.view import BodyView

MOST, FEWEST = 400, 60  # times of the animation of a run
NUMBERS = 250_000  # of the animations of a page
AT_ONCE = 4_000_000  # numbers in memory at a time


def frame_rows(t: Array, peaks: list[float], width: int, share: int) -> IntArray:
    """Rows of evenly spaced output times, with the first, the last and those of peaks.

    width : numbers of one time; share : numbers that this run may take
    """
    most = min(max(share // max(width, 1), FEWEST), MOST, len(t))
    even = np.linspace(0, len(t) - 1, most).round().astype(int)
    nearest = [int(np.argmin(np.abs(t - peak))) for peak in peaks]
    return np.unique(np.concatenate([even, np.array(nearest, dtype=int)]))


def one_sign(parameters: Array) -> Array:
    """Euler parameters (k, 4) with the sign of their neighbours, so that they interpolate."""
    same = (parameters[1:] * parameters[:-1]).sum(axis=1) >= 0
    signs = np.cumprod(np.concatenate([[1.0], np.where(same, 1.0, -1.0)]))
    return np.asarray(parameters * signs[:, None])


def largest_energy(view: BodyView, q: Array) -> float:
    """Largest strain energy for unit length or area of all sites and times.

    q : (k, m) modal coordinates at all output times
    """
    sites = view.sites
    if sites is None or not q.shape[1]:
        return 0.0
    C, R = sites.compliance[sites.kind], sites.resultants_E
    G = 0.5 * np.einsum("sim,sij,sjl->sml", R, C, R, optimize=True)
    one, two = np.triu_indices(q.shape[1])
    pairs = G[:, one, two] * np.where(one == two, 1.0, 2.0)
    step = max(1, AT_ONCE // max(len(pairs), len(one), 1))
    largest = 0.0
    for first in range(0, len(q), step):
        some = q[first : first + step]
        largest = max(largest, float((pairs @ (some[:, one] * some[:, two]).T).max(initial=0.0)))
    return largest


def largest_displacement(view: BodyView, q: Array) -> float:
    """Largest elastic displacement of all nodes and times [m]; q as above."""
    m = q.shape[1]
    if not m:  # taken as rigid
        return 0.0
    U = view.shapes_B[:, :, :3].reshape(m, 3 * view.shapes_B.shape[1])
    step = max(1, AT_ONCE // max(U.shape[1], 1))
    largest = 0.0
    for first in range(0, len(q), step):
        found = (q[first : first + step] @ U).reshape(-1, 3)
        largest = max(largest, float(np.einsum("ni,ni->n", found, found).max(initial=0.0)))
    return float(np.sqrt(largest))
