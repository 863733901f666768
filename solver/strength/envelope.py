"""Highest exposure of a set of points at every instant of a history.

The bounds of search.py exclude most points at most instants: at each instant, the point of the
highest bound is evaluated first, then every point whose bound is above what was found. The result
is therefore exact. Its cost depends on modes and points, not on the mesh of the section.
"""

from collections.abc import Sequence

import numpy as np

from ..math.arrays import Array, IntArray
from .search import ROUND_OFF, PeakSearch

FEW = 16  # points that are evaluated without bounds
AT_ONCE = 1_000_000  # numbers in memory at a time
LEADS = 8  # points that are evaluated at all instants


Place = tuple[Array, PeakSearch]  # resultants (6, m) of a station or (8, m) of a cell; its points


def envelope(places: Sequence[Place], q: Array) -> Array:
    """Highest exposure 1 / R of all points (t,) [-].

    Parameters
    ----------
    places : resultants per unit mode with the points to which they apply
    q : (t, m) modal coordinates
    """
    top = np.zeros(len(q))
    for resultants_E, search in _most_loaded_first(places, q):
        step = max(1, AT_ONCE // (6 * min(len(search.bounds), 1000)))
        for first in range(0, len(q), step):
            some = slice(first, first + step)
            raise_to_peaks(search, resultants_E @ q[some].T, top[some])
    return top


def raise_to_peaks(search: PeakSearch, F: Array, top: Array) -> None:
    """Raise top (t,), in place, to the highest exposure under resultants F (6 or 8, t)."""
    parts = np.maximum(np.concatenate([F, -F]), 0.0) * (1.0 + ROUND_OFF)
    live = np.flatnonzero(search.bounds.max(axis=0) @ parts > top)
    if not live.size:
        return
    if len(search.bounds) <= FEW:
        for point in range(len(search.bounds)):
            found = _exposures(search, F, np.full(live.size, point), live)
            top[live] = np.maximum(top[live], found)
        return
    upper = search.bounds @ parts[:, live]  # (p, instants)
    lead = np.argmax(upper, axis=0)
    number, times = np.unique(lead, return_counts=True)
    for point in number[np.argsort(-times, kind="stable")[:LEADS]]:
        found = _exposures(search, F, np.full(live.size, point), live)
        top[live] = np.maximum(top[live], found)
    top[live] = np.maximum(top[live], _exposures(search, F, lead, live))
    points, instants = np.nonzero(upper > top[live])
    for first in range(0, points.size, AT_ONCE // 36):
        some = slice(first, first + AT_ONCE // 36)
        at = live[instants[some]]
        np.maximum.at(top, at, _exposures(search, F, points[some], at))


def _exposures(search: PeakSearch, F: Array, points: IntArray, instants: IntArray) -> Array:
    stress = np.einsum("kij,jk->ki", search.stress_M[points], F[:, instants])
    return search.criterion.assess(stress, search.strength).exposure


def _most_loaded_first(places: Sequence[Place], q: Array) -> list[Place]:
    largest = np.abs(q).max(axis=0, initial=0.0)
    severity = [
        search.bounds.max(axis=0).reshape(2, -1).max(axis=0) @ (np.abs(F) @ largest)
        for F, search in places
    ]
    return [places[k] for k in np.argsort(-np.array(severity), kind="stable")]
