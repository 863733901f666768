"""Figure of the motion: the bodies at some times, and the path of the tip."""

from pathlib import Path
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..results import BodyGeometry, RunResult
from ..results.writer import frames
from .story import Story
from .style import GREY, INK, WARNING, Canvas

INSTANTS = 15
MOST = 4000  # times that a path is drawn through
AXES = "xyz"


def draw_motion(path: Path, story: Story) -> Path:
    """Draw all bodies at evenly spaced times in the plane of their largest motion."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    result = story.result
    first, second = plane(result)
    rows = frames(len(result.t), MOST)
    points = result.node_positions_G[rows][:, :, [first, second]]
    canvas = Canvas(5.4, 5.2)
    (axes,) = canvas.panels(1)
    # Pale to dark in one hue: the order in time is also visible in black and white.
    fade = LinearSegmentedColormap.from_list("age", ["#B5D4EA", "#4A97C9", "#0A2F4A"])
    scale = Normalize(0.0, max(float(result.t[-1]), 1e-12))
    tip = travelling_point(points)
    axes.plot(points[:, tip, 0], points[:, tip, 1], color="#D55E00", linewidth=0.9, zorder=2)
    chosen = frames(len(rows), INSTANTS)
    for k in chosen:
        shade = fade(scale(result.t[rows[k]]))
        start = 0
        for body in result.bodies:
            own = points[k, start : start + len(body.nodes_B)]
            lines = LineCollection(
                segments(body, own), colors=[shade], linewidths=2.4, capstyle="round", zorder=3
            )
            axes.add_collection(lines)
            if len(own):
                axes.plot(*own[[0, -1]].T, "o", color=shade, markersize=4.2, zorder=4)
            start += len(body.nodes_B)
    _words(axes, story, points[:, tip])
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.autoscale_view()
    axes.set_xlabel(f"{AXES[first]} [m]")
    axes.set_ylabel(f"{AXES[second]} [m]")
    axes.set_title(story.title)
    bar = canvas.figure.colorbar(
        ScalarMappable(scale, fade), ax=axes, shrink=0.7, aspect=28, pad=0.02
    )
    bar.set_label("time [s]", color=INK)
    bar.outline.set_visible(False)
    canvas.figure.supxlabel(
        f"{len(chosen)} equidistant times; orange: path of the outermost point",
        fontsize=7.5,
        color=GREY,
    )
    return canvas.save(path)


def plane(result: RunResult) -> tuple[int, int]:
    """Return the two global axes along which the points spread most, in order x, y, z."""
    some = result.node_positions_G[frames(len(result.t), MOST)]
    spread = np.ptp(some.reshape(-1, 3), axis=0)
    drop = int(np.argmin(spread + np.array([2e-12, 1e-12, 0.0])))  # prefer x-y on a tie
    first, second = (axis for axis in range(3) if axis != drop)
    return first, second


def travelling_point(points: Array) -> int:
    """Return the index of the point with the longest path, of points (k, n, 2)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=2).sum(axis=0)
    length = steps.max(initial=0.0)
    return int(np.flatnonzero(steps >= length * (1 - 1e-9))[-1]) if len(points) > 1 else -1


def segments(body: BodyGeometry, own: Array) -> list[Array]:
    """Return the polylines of a body's cells, surfaces by their outline."""
    found = []
    for begin, end, kind in zip(body.offsets[:-1], body.offsets[1:], body.cell_types, strict=True):
        rows = body.connectivity[begin:end]
        closed = kind not in (1, 2, 3, 4, 21)  # points, lines, polylines, quadratic edges
        if kind == 21:
            rows = rows[[0, 2, 1]]
        found.append(own[np.append(rows, rows[0]) if closed else rows])
    return found


def _words(axes: Any, story: Story, path: Array) -> None:
    last = "stop" if story.stopped else "end"
    t_end = float(story.result.t[-1])
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
    for at, text in ((0, "start"), (-1, f"{last}, {t_end:.4g} s")):
        red = at == -1 and story.stopped
        axes.annotate(
            text,
            path[at],
            xytext=(6, 6),
            textcoords="offset points",
            fontsize=8,
            color=WARNING if red else INK,
            bbox=box,
            zorder=6,
        )
