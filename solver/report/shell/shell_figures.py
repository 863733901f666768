"""Figures of a shell: the deflected surface over the edges of the undeformed one, in two views.

Cells are sorted by depth and drawn as flat polygons, without a 3-D plot. This is fast for a
mesh of a hundred thousand cells, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray
from ...package.common.cells import NONE, area_vectors, sides
from ...package.common.cells import centres as mean_of_corners
from ..style import GREY, INK, Canvas, house_style

WIDTH = 8.0  # inches, of two views
SHOWN = 0.12  # size of the largest displacement in the figure, relative to the shell
CREASE = 0.94  # cosine between the normals of neighbours; below it their edge is drawn
SLOPES = (0.4, 1.4)  # least and largest height over width of a view
MANY_CELLS = 4000  # larger meshes are drawn without mesh lines
VIEWS = (("from the corner", (1.0, -1.3, 0.9)), ("from the side", (0.25, -1.0, 0.12)))
_PREFIXES = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"))


@dataclass(frozen=True)
class Picture:
    """One deflected shape."""

    title: str
    name: str  # of the file, without its ending
    displacement: Array  # (n, 3) of the nodes [m]; arbitrary scale for a mode
    unit: str = "m"  # empty: a mode, its scale is arbitrary


def draw_shapes(
    points: Array, cells: IntArray, pictures: Sequence[Picture], folder: Path
) -> list[Path]:
    """Write <name>.png for each deflected shape into a folder; returns their paths.

    Parameters
    ----------
    points : (n, 3) nodes [m]
    cells : (c, 3) triangles, or (c, 4) with quadrilaterals

    Raises InputError without matplotlib.
    """
    edges = feature_edges(points, cells)
    folder.mkdir(parents=True, exist_ok=True)
    with house_style():
        return [
            _draw(points, cells, edges, picture, folder / f"{picture.name}.png")
            for picture in pictures
        ]


def feature_edges(points: Array, cells: IntArray) -> IntArray:
    """Edges where the surface ends, branches or has a fold, (e, 2) nodes."""
    normal = area_vectors(points, cells)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    ends, owner = sides(cells)
    edges, which, count = np.unique(
        np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    which = which.ravel()
    order = np.argsort(which, kind="stable")
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    shared = count == 2
    one, other = owner[order[first[shared]]], owner[order[first[shared] + 1]]
    drawn = ~shared
    turn = np.abs(np.einsum("ex,ex->e", normal[one], normal[other]))
    drawn[np.flatnonzero(shared)[turn < CREASE]] = True
    return np.asarray(edges[drawn])


def magnification(points: Array, displacement: Array) -> float:
    """Rounded factor that scales the largest displacement to a share of the size; 0 for none."""
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    largest = float(np.linalg.norm(displacement, axis=1).max(initial=0.0))
    if not largest > 0.0:
        return 0.0
    factor = SHOWN * size / largest
    step = 10.0 ** np.floor(np.log10(factor))
    return float(max(s for s in (1.0, 2.0, 5.0) if s <= factor / step * (1 + 1e-12)) * step)


def view_axes(direction: Sequence[float]) -> Array:
    """Rows right, up and towards the viewer, (3, 3), for a view from a direction; z is up."""
    towards = np.asarray(direction, dtype=float)
    towards = towards / np.linalg.norm(towards)
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards])


def _draw(points: Array, cells: IntArray, edges: IntArray, picture: Picture, path: Path) -> Path:
    factor = magnification(points, picture.displacement)
    moved = points + factor * picture.displacement
    size = np.linalg.norm(picture.displacement, axis=1)
    views = [view_axes(direction) for _, direction in VIEWS]
    windows, slope = _windows([np.concatenate([points, moved]) @ view.T for view in views])
    canvas = Canvas(WIDTH, 3.3 * slope + 1.0)
    canvas.figure.suptitle(picture.title, x=0.012, ha="left", fontsize=11, fontweight="bold")
    panels = canvas.panels(1, 2)
    largest = float(size.max(initial=0.0))
    unit_size, unit = next((p for p in _PREFIXES if largest >= p[0]), _PREFIXES[-1])
    if not picture.unit:
        unit_size, unit = largest or 1.0, "of the largest"
    shades = mean_of_corners(size[:, None], cells)[:, 0] / unit_size
    for axes, (name, _), view, window in zip(panels, VIEWS, views, windows, strict=True):
        surface = _view(axes, points, moved, cells, edges, shades, view, window)
        if axes is panels[0] and len(cells) <= MANY_CELLS:  # lines would cover flatter views
            surface.set(edgecolors=(1.0, 1.0, 1.0, 0.35), linewidths=0.25)
        surface.set_clim(0.0, largest / unit_size or 1.0)
        axes.set_title(name, fontsize=8.5, fontweight="normal", color=GREY)
    bar = canvas.figure.colorbar(surface, ax=panels, shrink=0.75, aspect=22, pad=0.015)
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=7.5, length=2, color=GREY)
    bar.set_label(f"|u| [{unit}]", fontsize=8.5)
    scale = f"displacements x {factor:g}" if picture.unit else "shape of arbitrary scale"
    canvas.figure.text(0.012, 0.012, f"{scale}; grey: undeformed", fontsize=8, color=GREY)
    return canvas.save(path)


def _windows(seen: Sequence[Array]) -> tuple[list[tuple[Array, Array]], float]:
    """Corners of each view, with equal ratios of height to width, and this ratio."""
    corners = []
    for places in seen:
        low, high = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
        margin = 0.06 * float(np.max(high - low))
        corners.append((low - margin * np.array([1.0, 2.5]), high + margin))
    slope = float(np.clip(max(np.divide(*(high - low)[::-1]) for low, high in corners), *SLOPES))
    windows = []
    for low, high in corners:
        width, height = high - low
        spare = 0.5 * np.array([max(height / slope - width, 0.0), max(slope * width - height, 0.0)])
        windows.append((low - spare, high + spare))
    return windows, slope


def _view(
    axes: Any,
    points: Array,
    moved: Array,
    cells: IntArray,
    edges: IntArray,
    shades: Array,
    view: Array,
    window: tuple[Array, Array],
) -> Any:
    from matplotlib.collections import LineCollection, PolyCollection

    before, after = points @ view.T, moved @ view.T
    depth = mean_of_corners(after, cells)[:, 2]
    order = np.argsort(depth, kind="stable")  # the farthest first
    lines = LineCollection(list(before[edges, :2]), colors=GREY, linewidths=0.7)
    axes.add_collection(lines, autolim=False)
    places = after[:, :2]
    if np.any(cells == NONE):
        corners: Any = [places[cell[cell != NONE]] for cell in cells[order]]
    else:  # an array is drawn in half of the time
        corners = places[cells[order]]
    surface = PolyCollection(corners, array=shades[order], cmap="viridis")
    surface.set(edgecolors="face", linewidths=0.2)
    axes.add_collection(surface, autolim=False)
    outline = LineCollection(list(after[edges, :2]), colors=INK, linewidths=0.5, alpha=0.6)
    axes.add_collection(outline, autolim=False)
    _tripod(axes, before, view)
    low, high = window
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_axis_off()
    return surface


def _tripod(axes: Any, seen: Array, view: Array) -> None:
    """Draw the directions x, y, z at the lower left."""
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    length = 0.09 * float(np.max(high - low))
    foot = np.array([low[0], low[1] - 0.9 * length])
    for direction, name in zip(view[:2].T, "xyz", strict=True):
        tip = foot + length * direction
        style = {"arrowstyle": "-", "color": INK, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, foot, arrowprops=style)
        if np.linalg.norm(direction) > 0.25:  # no label for an axis that points at the viewer
            axes.text(*(foot + 1.35 * length * direction), name, fontsize=7.5, color=INK,
                      ha="center", va="center")  # fmt: skip
