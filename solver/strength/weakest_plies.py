"""Stresses and strength ratios of a body from its modal coordinates.

The package of a shell or solid has the resultants of every mode in each cell and, for each
laminate, the stress of its plies per unit resultant at bottom, middle and top of each. Resultants
are means of their cells, so the highest stress of a coarse mesh is too low if it changes within a
cell. The outer faces of a solid are cells, too: their six stresses take the place of the
resultants, and each material that of a ply.

Exposures are bounded for every cell and block of times (see search.py) and evaluated in descending
order of the bounds, until no bound is above the exposure found. The result is therefore exact.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray, distinct
from ..package.body.package_schema import BodyRecovery, CellResultants, LaminateData, ModalPackage
from ..package.common.cells import cell_table, centres
from ..package.common.materials import PlyStrength, YieldStrength, material_from_dict
from ..package.common.recovery_schema import LEVELS, Ply, SectionRecovery, ShellPly
from ..package.section.stress import strengths
from . import Criterion, criteria_of
from .search import ROUND_OFF, Highest, PeakSearch
from .strength_summary import BodyStrength, CriticalPoint, ranked

# Beams.
#
# The package has the resultants of every mode at stations along the beam and, for each section, the
# strain of its points per unit resultant. A stress is therefore C_M strain_M resultants_E q. Its
# accuracy depends on the modes. The quasi-static response of omitted modes (to a load close to a
# support, to a concentrated mass on a short beam) is missing in the stress. This error is larger
# than that of the motion; more modes reduce it.


def resultants(package: ModalPackage, q: Array) -> Array:
    """Resultants at the stations of a package, section axes, (s, 6, t) [N, N m].

    q : (t, m) modal coordinates. Raises ValueError if the package has no recovery.
    """
    return np.asarray(_recovery(package).resultants_E @ q.T)


def unit_stress_M(recovery: SectionRecovery, points: IntArray | slice = slice(None)) -> Array:
    """Stress of points in their ply axes per unit resultant, (p, 6, 6) [Pa/N, Pa/(N m)]."""
    return np.asarray(recovery.C_M[recovery.ply[points]] @ recovery.strain_M[points])


def beam_search(package: ModalPackage) -> "BeamSearch | None":
    """Return the search of a beam; None without recovery or without strengths."""
    if package.recovery is None or not package.n_mode:
        return None
    search = BeamSearch(package)
    return search if search.exposure else None


class MaterialSearch(NamedTuple):
    """The points of one material of a section under one criterion."""

    criterion: Criterion
    strength: PlyStrength | YieldStrength
    recovery: SectionRecovery
    points: IntArray  # rows of the recovery's points
    plies: IntArray  # (g,) rows of the recovery's plies that have points
    peaks: PeakSearch


def material_searches(
    recovery: SectionRecovery, points: IntArray | None = None, criteria: tuple[str, ...] = ()
) -> Iterator[MaterialSearch]:
    """Yield the searches of a section.

    Parameters
    ----------
    points : rows of the recovery's points; absent: all
    criteria : names of those to be used; none given: all
    """
    material = np.array([ply.material for ply in recovery.plies])
    chosen = np.arange(len(recovery.ply)) if points is None else points
    for name, strength in strengths(recovery).items():
        own = chosen[(material == name)[recovery.ply[chosen]]]
        if not own.size:
            continue
        stress_M = unit_stress_M(recovery, own)
        plies, group = np.unique(recovery.ply[own], return_inverse=True)
        for criterion in criteria_of(strength):
            if not criteria or criterion.name in criteria:
                peaks = PeakSearch(stress_M, criterion, strength, group)
                yield MaterialSearch(criterion, strength, recovery, own, plies, peaks)


class BeamSearch:
    """The lowest strength ratio of every ply of a beam, over blocks of times."""

    def __init__(self, package: ModalPackage) -> None:
        self._package, self._stations = package, _recovery(package)
        self._searches = [
            (np.flatnonzero(self._stations.section == row), search)
            for row, section in enumerate(package.sections)
            if section.recovery is not None
            for search in material_searches(section.recovery)
        ]
        n = len(self._stations.station_x)
        criteria = {search.criterion for _, search in self._searches}
        names = sorted(criteria, key=lambda c: (c.order, c.name))
        self.exposure = {criterion.name: np.zeros(n) for criterion in names}
        self._highest: dict[Ply, float] = {}  # by all criteria
        self._peaks: dict[tuple[Ply, str], CriticalPoint] = {}

    def take(self, t: Array, q: Array) -> None:
        """Look at times t (k,) with modal coordinates q (k, m)."""
        F = np.moveaxis(resultants(self._package, q), 1, 0)  # (6, s, k)
        for stations, search in self._searches:
            if stations.size:
                self._look(search, stations, t, F[:, stations].reshape(len(F), -1))

    def _look(self, search: MaterialSearch, stations: IntArray, t: Array, F: Array) -> None:
        name, plies = search.criterion.name, search.recovery.plies
        groups = Highest(np.array([self._highest.get(plies[ply], 0.0) for ply in search.plies]))
        cases = Highest(self.exposure[name][stations])
        search.peaks.peaks(F, np.repeat(np.arange(stations.size), t.size), groups, cases)
        self.exposure[name][stations] = cases.exposure
        found = [*zip(groups.exposure, groups.point, groups.column, strict=True)]
        found += [(0.0, rows[0], 0) for rows in search.peaks.members]  # of plies without a peak
        top = int(np.argmax(cases.exposure))
        found.append((cases.exposure[top], cases.point[top], cases.column[top]))
        for exposure, point, column in found:
            row = search.points[point]
            ply, (x2, x3) = plies[search.recovery.ply[row]], search.recovery.points[row]
            peak = self._peaks.get((ply, name))
            if point < 0 or (peak is not None and peak.exposure >= exposure):
                continue
            self._highest[ply] = max(self._highest.get(ply, 0.0), float(exposure))
            self._peaks[ply, name] = CriticalPoint(
                float(exposure),
                search.peaks,
                int(point),
                F[:, column].copy(),
                float(t[column % t.size]),
                float(self._stations.station_x[stations[column // t.size]]),
                search.recovery.points[row],
                f"x2 = {x2:.4g} m, x3 = {x3:.4g} m",
                ply,
            )

    def found(self) -> BodyStrength | None:
        """Return what was found so far."""
        plied = [k for k, each in enumerate(self._package.sections) if each.recovery is not None]
        there = np.isin(self._stations.section, plied)
        exposure = {name: values[there] for name, values in self.exposure.items()}
        return ranked(self._stations.station_x[there], exposure, self._peaks)


def _recovery(package: ModalPackage) -> BodyRecovery:
    if package.recovery is None:
        raise ValueError(f"{package.body}: the package has no recovery of resultants")
    return package.recovery


BLOCK = 16  # times per block
STRIPS = 20  # strips across the body's x, each with its highest exposure
AT_ONCE = 2_000_000  # numbers in memory at a time
FIRST, MOST = 8, 512  # pairs of cell and block that are evaluated together


def body_search(package: ModalPackage) -> "BeamSearch | ShellSearch | None":
    """Return the search of a body; None without stresses or without strengths."""
    if package.recovery is not None:
        return beam_search(package)
    cells, laminates = stressed_cells(package)
    if cells is None or not package.n_mode or not len(cells.cell):
        return None
    search = ShellSearch(package, cells, laminates)
    return search if search.exposure else None


def stressed_cells(
    package: ModalPackage,
) -> tuple[CellResultants | None, tuple[LaminateData, ...]]:
    """Resultants and laminates of a shell's cells; of a solid the stresses of its outer faces.

    Those six are then the resultants (f, 6, m) [Pa] of a ply `surface MATERIAL`, whose stress they
    are, and its ABD is the stiffness (6, 6) [Pa] of the material.
    """
    faces = package.face_stresses
    if faces is None:
        return package.cell_resultants, package.laminates
    cells = CellResultants(faces.cell, faces.material, faces.A_BM, faces.stress_M)
    none = np.zeros((0, 0))
    return cells, tuple(
        LaminateData(
            f"surface {name}",
            (ShellPly(name, 0.0, 0.0, 0.0),),
            material_from_dict(table, name).stiffness_M,
            none,
            np.eye(6)[None, None],
            {name: dict(table)},
        )
        for name, table in sorted(faces.materials.items())
    )


class ShellSearch:
    """The lowest strength ratio of every ply of a shell, over blocks of times."""

    def __init__(
        self, package: ModalPackage, cells: CellResultants, laminates: tuple[LaminateData, ...]
    ) -> None:
        self._cells = cells
        self._searches = [
            _Search(row, laminate, *searches)
            for row, laminate in enumerate(laminates)
            for searches in ply_searches(laminate, range(len(laminate.plies)))
        ]
        self._centre_B = cell_centres(package, cells)
        self._strip, self._middle = _strips(self._centre_B[:, 0])
        names = sorted({s.peaks.criterion for s in self._searches}, key=lambda c: (c.order, c.name))
        self.exposure = {criterion.name: np.zeros(len(self._middle)) for criterion in names}
        self._peaks: dict[tuple[Ply, str], CriticalPoint] = {}

    def take(self, t: Array, q: Array) -> None:
        """Look at times t (k,) with modal coordinates q (k, m)."""
        cells = self._cells
        parts, starts = _blocks(cells, q)
        for search in self._searches:
            name = search.peaks.criterion.name
            along, key = self.exposure[name], (search.ply, name)
            own = np.flatnonzero(cells.laminate == search.laminate_row)
            bound = search.bound(parts[own])  # (cells, blocks)
            for number in distinct(self._strip[own]):
                inside = np.flatnonzero(self._strip[own] == number)
                best = self._peaks.get(key)
                floor = 0.0 if best is None else min(float(along[number]), best.exposure)
                R = cells.resultants_E[own[inside]]
                highest, place = search.peak(R, q, bound[inside], starts, floor)
                along[number] = max(along[number], highest)
                if best is None or (place is not None and highest > best.exposure):
                    cell, point, instant = place or (0, 0, 0)
                    at, level = self._centre_B[own[inside[cell]]], ""
                    if len(search.points) > 1:
                        level = f", at its {LEVELS[search.points[point, 1]]}"
                    self._peaks[key] = CriticalPoint(
                        highest,
                        search.peaks,
                        point,
                        R[cell] @ q[instant],
                        float(t[instant]),
                        float(at[0]),
                        at,
                        f"y = {at[1]:.4g} m, z = {at[2]:.4g} m{level}",
                        search.ply,
                    )

    def found(self) -> BodyStrength | None:
        """Return what was found so far."""
        return ranked(self._middle, self.exposure, self._peaks)


class _Place(NamedTuple):
    """A point of a search in one of its cells at one time."""

    cell: int
    point: int
    instant: int


class _Search(NamedTuple):
    """A ply of a laminate under one criterion; `points` are ply and level."""

    laminate_row: int
    laminate: LaminateData
    points: IntArray  # (p, 2)
    peaks: PeakSearch

    @property
    def ply(self) -> Ply:
        """The ply of its first point."""
        number = int(self.points[0, 0])
        ply = self.laminate.plies[number]
        return Ply(self.laminate.name, number, ply.material, ply.angle_deg)

    def bound(self, parts: Array) -> Array:
        """Upper bound of the exposure of cells in blocks of times, (e, b), from parts (e, b,
        2 r)."""
        out = np.empty(parts.shape[:2])
        step = max(1, AT_ONCE // (parts.shape[1] * len(self.points)))
        for first in range(0, len(out), step):
            some = parts[first : first + step]
            flat = some.reshape(-1, some.shape[2]) @ self.peaks.bounds.T
            out[first : first + step] = flat.max(axis=1).reshape(some.shape[:2])
        return out * (1.0 + ROUND_OFF)

    def peak(
        self, R: Array, q: Array, bound: Array, starts: IntArray, floor: float
    ) -> tuple[float, _Place | None]:
        """Highest exposure above `floor` of some cells, and its position among these cells.

        `R` (e, r, m) are their resultants per unit mode, `bound` (e, b) as above.
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
            exposures = self.peaks.criterion.assess(stress, self.peaks.strength).exposure
            k, t, p = (int(n) for n in np.unravel_index(np.argmax(exposures), exposures.shape))
            if exposures[k, t, p] > best:
                best = float(exposures[k, t, p])
                place = _Place(int(cell[k]), p, int(instant[k, t]))
            first, count = first + count, min(2 * count, MOST)
        return best, place


def ply_searches(
    laminate: LaminateData, plies: Iterable[int], criteria: tuple[str, ...] = ()
) -> Iterator[tuple[IntArray, PeakSearch]]:
    """Yield points (p, 2), ply and level, of each of some plies, and their search.

    Parameters
    ----------
    laminate : a laminate of the package
    plies : numbers of the plies
    criteria : names of the criteria to use; none given: all
    """
    known = strengths(laminate)
    for number in plies:
        strength = known.get(laminate.plies[number].material)
        if strength is None:
            continue
        levels = range(laminate.stress_M.shape[1])
        points = np.array([(number, level) for level in levels], dtype=np.int64)
        for criterion in criteria_of(strength):
            if not criteria or criterion.name in criteria:
                yield points, PeakSearch(laminate.stress_M[number], criterion, strength)


def _blocks(cells: CellResultants, q: Array) -> tuple[Array, IntArray]:
    """Largest positive and negative value of each resultant in blocks of times, (e, b, 2 r), and
    the first time of each block."""
    starts = np.arange(0, len(q), BLOCK)
    r = cells.resultants_E.shape[1]
    out = np.empty((len(cells.cell), len(starts), 2 * r))
    step = max(1, AT_ONCE // (r * len(q)))
    for first in range(0, len(out), step):
        some = slice(first, first + step)
        F = cells.resultants_E[some] @ q.T
        for part, sign in ((slice(0, r), 1.0), (slice(r, 2 * r), -1.0)):
            out[some, :, part] = np.maximum.reduceat(sign * F, starts, axis=2).swapaxes(1, 2)
    return np.maximum(out, 0.0), starts


def cell_centres(package: ModalPackage, cells: CellResultants) -> Array:
    """Middle of each cell, (e, 3) [m]."""
    table = cell_table(package.connectivity, package.offsets, cells.cell)
    return centres(package.nodes_B, table)


def _strips(x: Array) -> tuple[IntArray, Array]:
    """Strip across x of each cell, and the middles of strips with cells [m]."""
    width = float(np.ptp(x)) or 1.0
    number = np.minimum((STRIPS * (x - x.min()) / width).astype(np.int64), STRIPS - 1)
    used, strip = np.unique(number, return_inverse=True)
    return strip, x.min() + (used + 0.5) * width / STRIPS
