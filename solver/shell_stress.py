"""Ply stresses and strength ratios of a shell body from its modal coordinates.

The package holds the resultants of every mode in each cell and, for each laminate, the stress of
its plies per unit resultant at bottom, middle and top of each. What is said in ply_stress.py of
modes and stresses holds here too; resultants are means of their cells, so that the highest stress
of a coarse mesh is too low where it changes within a cell.

Cells are looked at from the highest bound of their exposure down, until no bound is above the
exposure found: nothing is missed (see strength/search.py).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .package.laminate_data import CellResultants, LaminateData
from .package.recovery_data import strengths
from .package.schema import Array, IntArray, ModalPackage
from .package.section import Ply
from .package.shell_file import LEVELS
from .ply_stress import BodyStrength, Failure
from .strength import criteria_of
from .strength.search import ROUND_OFF, PeakSearch

STRIPS = 40  # across the body's x, of which each tells its highest exposure
AT_ONCE = 2_000_000  # resultants in memory


def shell_resultants(package: ModalPackage, rows: IntArray, q: Array) -> Array:
    """Resultants N, M, T of some cells in their axes, (cells, 8, t) [N/m, N].

    Parameters
    ----------
    rows : of the package's cell resultants
    q : (t, m) modal coordinates

    Raises
    ------
    ValueError : the package has no resultants of cells.
    """
    return np.asarray(_cells(package).resultants_E[rows] @ q.T)


def shell_ply_stress(package: ModalPackage, row: int, q: Array) -> Array:
    """Stress in the plies of one cell in ply axes, (t, k, 3, 6) [Pa].

    Ply from the bottom up; bottom, middle and top of it; 11, 22, 33, 23, 13, 12. Arguments and
    errors as in `shell_resultants`.
    """
    laminate = package.laminates[_cells(package).laminate[row]]
    (found,) = shell_resultants(package, np.array([row]), q)
    return np.moveaxis(laminate.stress_M @ found, -1, 0)


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
    largest = _largest(cells, q)
    centre_B = _centres(package, cells)
    strip, middle = _strips(centre_B[:, 0])
    exposure: dict[str, Array] = {}
    worst: dict[str, tuple[float, _Search, int, int, int]] = {}
    for search in searches:
        name = search.peaks.criterion.name
        along = exposure.setdefault(name, np.zeros(len(middle)))
        own = np.flatnonzero(cells.laminate == search.laminate_row)
        bound = (largest[own] @ search.peaks.bounds.T).max(axis=1) * (1.0 + ROUND_OFF)
        for i in np.argsort(-bound, kind="stable"):
            row = own[i]
            floor = float(along[strip[row]])
            if bound[i] <= floor:
                continue
            peak = search.peaks.peak(cells.resultants_E[row] @ q.T, floor=floor)
            along[strip[row]] = max(floor, peak.exposure)
            if name not in worst or peak.exposure > worst[name][0]:
                worst[name] = (peak.exposure, search, int(row), peak.point, peak.instant)
    found = {
        name: _failure(cells, centre_B, t, q, *place) for name, (_, *place) in worst.items()
    }
    return BodyStrength(middle, exposure, found) if found else None


@dataclass(frozen=True)
class _Search:
    """The plies of one material of a laminate under one criterion; `points` are ply and level."""

    laminate_row: int
    laminate: LaminateData
    points: IntArray  # (p, 2)
    peaks: PeakSearch


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


def _cells(package: ModalPackage) -> CellResultants:
    if package.cell_resultants is None:
        raise ValueError(f"{package.body}: the package has no resultants of cells")
    return package.cell_resultants


def _largest(cells: CellResultants, q: Array) -> Array:
    """Largest of each resultant of each cell over time, upwards and downwards, (e, 16)."""
    out = np.empty((len(cells.cell), 16))
    step = max(1, AT_ONCE // (8 * len(q)))
    for first in range(0, len(out), step):
        some = slice(first, first + step)
        F = cells.resultants_E[some] @ q.T
        out[some, :8], out[some, 8:] = F.max(axis=2), -F.min(axis=2)
    return np.maximum(out, 0.0)


def _centres(package: ModalPackage, cells: CellResultants) -> Array:
    """Middle of each cell, (e, 3) [m]."""
    corners = package.connectivity[package.offsets[cells.cell][:, None] + np.arange(3)]
    return np.asarray(package.nodes_B[corners].mean(axis=1))


def _strips(x: Array) -> tuple[IntArray, Array]:
    """Strip of each cell across x, and the middles of strips that have cells [m]."""
    width = float(np.ptp(x)) or 1.0
    number = np.minimum((STRIPS * (x - x.min()) / width).astype(np.int64), STRIPS - 1)
    used, strip = np.unique(number, return_inverse=True)
    return strip, x.min() + (used + 0.5) * width / STRIPS


def _failure(
    cells: CellResultants,
    centre_B: Array,
    t: Array,
    q: Array,
    search: _Search,
    row: int,
    point: int,
    instant: int,
) -> Failure:
    stress_M = search.peaks.stress_M[point] @ (cells.resultants_E[row] @ q[instant])
    verdict = search.peaks.criterion.assess(stress_M, search.peaks.strength)
    number, level = search.points[point]
    ply = search.laminate.plies[number]
    place = centre_B[row]
    return Failure(
        criterion=search.peaks.criterion.name,
        mode=verdict.modes[int(verdict.mode)],
        ratio=float(verdict.ratio),
        index=float(verdict.index),
        x=float(place[0]),
        point=place,
        ply=Ply(search.laminate.name, int(number), ply.material, ply.angle_deg),
        time=float(t[instant]),
        stress_M=stress_M,
        place=f"y = {place[1]:.4g} m, z = {place[2]:.4g} m, at its {LEVELS[level]}",
    )
