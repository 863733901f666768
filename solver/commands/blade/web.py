"""Webs of a station: their feet on the contour, and their cells.

A foot is a group of columns between which the layers of a web begin. Its widths on the contour are
chosen so that the layers have their thickness across the web: on the inner face of a thick curved
wall, and where a web stands obliquely on it, the distances of columns are others than on the
contour.
"""

import itertools
import math
from dataclasses import replace

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray
from .cells import StationMesh
from .wall import WebLayers

WIDEST = 3.0  # width on the contour over the thickness of a layer


def feet_of(web: WebLayers, perimeter: float, spacing: float = math.inf) -> Array:
    """Arcs of the boundaries of a web's layers: on the suction and the pressure side (2, n).

    Layers that are wide beside `spacing` [-] have columns between them, equally many on both sides.
    """
    plain = tuple(layer.thickness for layer in web.layers)
    found = []
    # From the leading edge to the trailing edge: arcs fall on the suction side.
    for middle, sense, widths in zip(
        (web.start, web.end), (-1.0, 1.0), web.widths or (plain, plain), strict=True
    ):
        steps = np.concatenate([[0.0], np.cumsum(widths)]) / perimeter
        found.append(middle + sense * (steps - 0.5 * steps[-1]))
    feet = np.array(found)
    counts = np.maximum(1, np.round(np.abs(np.diff(feet, axis=1)).max(axis=0) / spacing))
    at = np.concatenate([[0.0], np.cumsum(counts)])
    return np.array([np.interp(np.arange(at[-1] + 1.0), at, foot) for foot in feet])


def fitted(
    webs: list[WebLayers], arcs: Array, inner: Array, perimeter: float
) -> tuple[list[WebLayers], float]:
    """Return webs whose feet give the layers their thickness, and the largest relative change.

    Parameters
    ----------
    inner : (n, 2) places of the columns on the inner face of the wall [m]
    """
    found, largest = [], 0.0
    for web in webs:
        feet = inner[_columns_of(web, arcs, perimeter)]  # (2, n, 2)
        run = feet[1].mean(axis=0) - feet[0].mean(axis=0)
        across = np.array([-run[1], run[0]]) / np.linalg.norm(run)
        has = np.abs(np.diff(feet, axis=1) @ across)
        wanted = np.array([layer.thickness for layer in web.layers])
        old = np.diff(feet_of(web, perimeter), axis=1) * perimeter
        new = np.abs(old) * wanted / np.maximum(has, wanted / WIDEST)
        new = np.minimum(new, WIDEST * wanted)
        largest = max(largest, float(np.abs(new / np.abs(old) - 1.0).max()))
        found.append(replace(web, widths=(tuple(new[0].tolist()), tuple(new[1].tolist()))))
    return found, largest


def _columns_of(web: WebLayers, arcs: Array, perimeter: float) -> IntArray:
    """Columns of the boundaries of a web's layers (2, n)."""
    return np.asarray(np.abs(arcs - feet_of(web, perimeter)[..., None]).argmin(axis=-1))


def check_feet(webs: list[WebLayers], perimeter: float, low: float, high: float) -> None:
    """Refuse feet that reach past the ends of the contour or over those of another web."""
    taken: list[tuple[float, float, str]] = []
    for web in webs:
        for foot in feet_of(web, perimeter):
            one, two = float(foot.min()), float(foot.max())
            key = f"structure.webs: {web.name}: its foot covers the arcs {one:.5f} to {two:.5f}"
            if one <= low or two >= high:
                raise InputError(f"{key}; expected arcs from {low:.5f} to {high:.5f}")
            for start, end, other in taken:
                if one < end and two > start:
                    words = f"expected none of those of {other}, {start:.5f} to {end:.5f}"
                    raise InputError(f"{key}; {words}")
            taken.append((one, two, web.name))


def level_under(web: WebLayers, t: Array, arcs: Array, perimeter: float) -> None:
    """Give the wall one thickness under each foot of a web, the mean of what it has there."""
    for foot in feet_of(web, perimeter):
        at = np.flatnonzero((arcs > foot.min() - 1e-9) & (arcs < foot.max() + 1e-9))
        width = arcs[at[-1]] - arcs[at[0]]
        t[:, at] = (np.trapezoid(t[:, at], arcs[at], axis=1) / width)[:, None]


def add_web(
    mesh: StationMesh,
    web: WebLayers,
    arcs: Array,
    inner: list[int],
    perimeter: float,
    size: float,
) -> None:
    """Add a strip between the two feet; `inner` are nodes, `size` the length of its cells [m]."""
    columns = _columns_of(web, arcs, perimeter)
    one, two = ([inner[k] for k in _every(side)] for side in columns)
    start, end = (np.array([mesh.nodes[k] for k in line]) for line in (one, two))
    height = float(np.linalg.norm(end - start, axis=1).min())
    count = max(4, round(height / size))
    grid = [one]
    for k in range(1, count):
        f = k / count
        grid.append([mesh.node(p) for p in (1.0 - f) * start + f * end])
    grid.append(two)
    run = end.mean(axis=0) - start.mean(axis=0)
    ends = np.abs(columns[0] - columns[0, 0])
    for band, first, last in zip(web.layers, ends[:-1], ends[1:], strict=True):
        for a in range(first, last):
            for lower, upper in itertools.pairwise(grid):
                corners = (lower[a], lower[a + 1], upper[a + 1], upper[a])
                mesh.cell(corners, band)
        mesh.directions[band.name] = (float(run[0]), float(run[1]))


def _every(columns: IntArray) -> range:
    """All columns from the first to the last, which may lie before it."""
    step = 1 if columns[-1] > columns[0] else -1
    return range(columns[0], columns[-1] + step, step)
