"""Ply stresses and strength ratios of a shell body from its modal coordinates.

The package has the resultants of every mode in each cell and, for each laminate, the stress of
its plies per unit resultant at bottom, middle and top of each. The remarks in beam_bodies.py on
modes and stresses hold here too. Resultants are means of their cells, so the highest stress
of a coarse mesh is too low if it changes within a cell.

Exposures are bounded for every cell and block of times (see search.py) and evaluated in descending
order of the bounds, until no bound is above the exposure found. The result is therefore exact.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray
from ..package.body.laminate_data import CellResultants, LaminateData
from ..package.body.schema import ModalPackage
from ..package.section.recovery_data import strengths
from ..package.section.schema import Ply
from ..package.shell.schema import LEVELS
from . import criteria_of
from .beam_bodies import BodyStrength, Failure
from .search import BLOCK, ROUND_OFF, PeakSearch

STRIPS = 20  # strips across the body's x, each with its highest exposure
AT_ONCE = 2_000_000  # numbers in memory at a time
FIRST, MOST = 8, 512  # pairs of cell and block that are evaluated together


def shell_strength(package: ModalPackage, t: Array, q: Array) -> BodyStrength | None:
    """Find the lowest strength ratio of a shell; None without resultants or without strengths.

    Parameters
    ----------
    t, q : (t,) times [s] and (t, m) modal coordinates at these
    """
    cells = package.cell_resultants
    if cells is None or not package.n_mode or not len(cells.cell):
        return None
    searches = [
        _Search(row, laminate, *found)
        for row, laminate in enumerate(package.laminates)
        for found in _searches(laminate)
    ]
    if not searches:
        return None
    parts, starts = _blocks(cells, q)
    centre_B = _centres(package, cells)
    strip, middle = _strips(centre_B[:, 0])
    exposure: dict[str, Array] = {}
    worst: dict[str, tuple[float, _Place]] = {}
    for search in searches:
        name = search.peaks.criterion.name
        along = exposure.setdefault(name, np.zeros(len(middle)))
        own = np.flatnonzero(cells.laminate == search.laminate_row)
        bound = search.bound(parts[own])  # (cells, blocks)
        for number in np.unique(strip[own]):
            inside = np.flatnonzero(strip[own] == number)
            highest, place = search.peak(
                cells.resultants_E[own[inside]], q, bound[inside], starts, float(along[number])
            )
            along[number] = max(along[number], highest)
            if place is not None and (name not in worst or highest > worst[name][0]):
                worst[name] = (highest, place._replace(row=int(own[inside[place.row]])))
    found = {name: _failure(cells, centre_B, t, q, place) for name, (_, place) in worst.items()}
    return BodyStrength(middle, exposure, found) if found else None


class _Place(NamedTuple):
    """A point of a search in one cell at one time."""

    search: "_Search"
    row: int
    point: int
    instant: int


@dataclass(frozen=True)
class _Search:
    """The plies of one material of a laminate under one criterion; `points` are ply and level."""

    laminate_row: int
    laminate: LaminateData
    points: IntArray  # (p, 2)
    peaks: PeakSearch

    def bound(self, parts: Array) -> Array:
        """Upper bound of the exposure of cells in blocks of times, (e, b), from parts (e, b,
        16)."""
        out = np.empty(parts.shape[:2])
        step = max(1, AT_ONCE // (parts.shape[1] * len(self.points)))
        for first in range(0, len(out), step):
            some = parts[first : first + step]
            flat = some.reshape(-1, 16) @ self.peaks.bounds.T
            out[first : first + step] = flat.max(axis=1).reshape(some.shape[:2])
        return out * (1.0 + ROUND_OFF)

    def peak(
        self, R: Array, q: Array, bound: Array, starts: IntArray, floor: float
    ) -> tuple[float, _Place | None]:
        """Highest exposure above `floor` of some cells, and its position; `row` counts these cells.

        `R` (e, 8, m) are their resultants per unit mode, `bound` (e, b) as above.
        """
        best, place = floor, None
        left = np.flatnonzero(bound.ravel() > best)
        order = left[np.argsort(-bound.ravel()[left], kind="stable")]
        first, count = 0, FIRST
        while first < len(order) and bound.flat[order[first]] > best:
            cell, block = np.divmod(order[first : first + count], bound.shape[1])
            instant = np.minimum(starts[block][:, None] + np.arange(BLOCK), len(q) - 1)
            F = np.einsum("kim,ktm->kti", R[cell], q[instant], optimize=True)
            stress = np.einsum("pij,ktj->ktpi", self.peaks.stress_M, F, optimize=True)
            found = self.peaks.criterion.assess(stress, self.peaks.strength).exposure
            k, t, p = (int(n) for n in np.unravel_index(np.argmax(found), found.shape))
            if found[k, t, p] > best:
                best = float(found[k, t, p])
                place = _Place(self, int(cell[k]), p, int(instant[k, t]))
            first, count = first + count, min(2 * count, MOST)
        return best, place


def _searches(laminate: LaminateData) -> Iterator[tuple[IntArray, PeakSearch]]:
    material = np.array([ply.material for ply in laminate.plies])
    for name, strength in strengths(laminate).items():
        plies = np.flatnonzero(material == name)
        if not plies.size:
            continue
        points = np.stack(np.meshgrid(plies, range(len(LEVELS)), indexing="ij"), -1).reshape(-1, 2)
        stress_M = laminate.stress_M[points[:, 0], points[:, 1]]
        for criterion in criteria_of(strength):
            yield points, PeakSearch(stress_M, criterion, strength)


def _blocks(cells: CellResultants, q: Array) -> tuple[Array, IntArray]:
    """Largest positive and negative value of each resultant in blocks of times, (e, b, 16), and the
    first time of each block."""
    starts = np.arange(0, len(q), BLOCK)
    out = np.empty((len(cells.cell), len(starts), 16))
    step = max(1, AT_ONCE // (8 * len(q)))
    for first in range(0, len(out), step):
        some = slice(first, first + step)
        F = cells.resultants_E[some] @ q.T
        for part, sign in ((slice(0, 8), 1.0), (slice(8, 16), -1.0)):
            out[some, :, part] = np.maximum.reduceat(sign * F, starts, axis=2).swapaxes(1, 2)
    return np.maximum(out, 0.0), starts


def _centres(package: ModalPackage, cells: CellResultants) -> Array:
    """Middle of each cell, (e, 3) [m]."""
    corners = package.connectivity[package.offsets[cells.cell][:, None] + np.arange(3)]
    return np.asarray(package.nodes_B[corners].mean(axis=1))


def _strips(x: Array) -> tuple[IntArray, Array]:
    """Strip across x of each cell, and the middles of strips with cells [m]."""
    width = float(np.ptp(x)) or 1.0
    number = np.minimum((STRIPS * (x - x.min()) / width).astype(np.int64), STRIPS - 1)
    used, strip = np.unique(number, return_inverse=True)
    return strip, x.min() + (used + 0.5) * width / STRIPS


def _failure(cells: CellResultants, centre_B: Array, t: Array, q: Array, at: _Place) -> Failure:
    search = at.search
    stress_M = search.peaks.stress_M[at.point] @ (cells.resultants_E[at.row] @ q[at.instant])
    verdict = search.peaks.criterion.assess(stress_M, search.peaks.strength)
    number, level = search.points[at.point]
    ply = search.laminate.plies[number]
    place = centre_B[at.row]
    return Failure(
        criterion=search.peaks.criterion.name,
        mode=verdict.modes[int(verdict.mode)],
        ratio=float(verdict.ratio),
        index=float(verdict.index),
        x=float(place[0]),
        point=place,
        ply=Ply(search.laminate.name, int(number), ply.material, ply.angle_deg),
        time=float(t[at.instant]),
        stress_M=stress_M,
        place=f"y = {place[1]:.4g} m, z = {place[2]:.4g} m, at its {LEVELS[level]}",
    )
