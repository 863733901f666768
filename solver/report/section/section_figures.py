"""Figures of a section: mesh with plies, and stresses under unit resultants."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from ...math.arrays import Array
from ...package.common.recovery_schema import RESULTANTS
from ...package.section.section_schema import SectionFile
from ...package.section.stress import cell_means, unit_stress
from ..style import GREY, INK, WARNING, Canvas, house_style, plain_words
from .drawing import (
    CellField,
    Detail,
    Shape,
    detail_of,
    fill,
    frame,
    is_isotropic,
    nearest_to_mean,
    normal,
    outer_cells,
    ply_colours,
    ply_legend,
    shape_of,
)

# The mesh of a section with its plies, layer directions and centres.

WIDTH = 8.0  # inches
SIDE = 2.75  # of the column beside sections that are not wide
MARGIN = np.array([0.17, 0.11])  # around the mesh, for the names of regions; share of its size
MOST_NAMES = 14  # of regions
MANY_CELLS = 1500  # meshes of more cells have finer lines
DASHED = (0, (4, 2))  # the window of the detail
HAIR = 0.008  # share of the size: thinner walls are drawn without lines of the mesh
ARROW = 0.085  # length of a layer direction, share of the size
TURNING = math.radians(10.0)  # layer directions that differ more are shown at several places
ROUND_OFF = 1e-6  # coordinates below this share of the size are shown as 0
CENTRES = (  # name, field, marker, size: coincident ones remain visible one inside the other
    ("shear centre", "shear_centre", "o", 13.0),
    ("tension centre", "tension_centre", "s", 8.5),
    ("mass centre", "mass_centre", "D", 4.0),
)


def draw_mesh(section: SectionFile, shape: Shape, path: Path) -> Path:
    """Draw mesh, plies, directions and centres; the file appears only when it is complete.

    Parameters
    ----------
    section : results of the section
    shape : outline and cells of the section
    path : file of the picture
    """
    colours, row = ply_colours(section)
    faces = [colours[row[ply]].colour for ply in section.mesh.ply]
    detail = detail_of(section, shape)
    low, high = _shown(section, shape)
    width, height = high - low
    beside = width < 1.5 * height
    if beside:
        tall = min((WIDTH - SIDE - 0.7) * height / width, 6.5) + 0.75
        canvas = Canvas(WIDTH, max(tall, 4.9 if detail else 3.6) + 0.3)
        grid = canvas.figure.add_gridspec(1, 2, width_ratios=[WIDTH - SIDE, SIDE])
        parts = grid[1].subgridspec(3, 1, height_ratios=[2.3 if detail else 0.01, 1.4, 1.1])
    else:
        tall = max((WIDTH - 0.9) * height / width, 0.8) + 0.5
        low_part = 2.2 if detail else 1.4
        canvas = Canvas(WIDTH, tall + low_part + 0.4)
        grid = canvas.figure.add_gridspec(2, 1, height_ratios=[tall, low_part])
        parts = grid[1].subgridspec(1, 3, width_ratios=[2.3 if detail else 0.01, 2.6, 2.6])
    room = {"w_pad": 0.08, "h_pad": 0.1, "rect": (0.0, 0.02, 1.0, 0.98)}
    canvas.figure.set_layout_engine("constrained", **room)
    canvas.figure.suptitle(
        plain_words(section.name), x=0.012, ha="left", fontsize=11, fontweight="bold"
    )
    axes = canvas.figure.add_subplot(grid[0])
    _cells(axes, section, shape, faces, detail)
    _directions(axes, section, shape)
    axes.plot(0, 0, "+", color=INK, markersize=17, markeredgewidth=1.0, zorder=6)
    for _, field, marker, size in CENTRES:
        axes.plot(*(shape.scale * getattr(section, field)), **_mark(marker, size), zorder=6)
    frame(axes, low, high)
    axes.set_xlabel(f"$x_2$ [{shape.unit}]     ($x_1$ towards you)")
    axes.set_ylabel(f"$x_3$ [{shape.unit}]")
    if detail:
        (x, y), (w, h) = detail.low, detail.high - detail.low
        axes.add_patch(Rectangle((x, y), w, h, fill=False, ec=INK, lw=0.8, ls=DASHED))
        _enlarged(canvas.figure.add_subplot(parts[0]), section, shape, detail, faces)
    ply_legend(canvas.figure.add_subplot(parts[1]), colours)
    _centre_legend(canvas.figure.add_subplot(parts[2]), section, shape)
    return canvas.save(path)


def _shown(section: SectionFile, shape: Shape) -> tuple[Array, Array]:
    """Corners of the drawing: mesh, reference point and centres, with a margin."""
    points = [shape.scale * getattr(section, field) for _, field, _, _ in CENTRES]
    low = np.min([*points, np.zeros(2), shape.low], axis=0)
    high = np.max([*points, np.zeros(2), shape.high], axis=0)
    low = np.minimum(low - 0.05 * shape.size, shape.low - MARGIN * shape.size)
    return low, np.maximum(high + 0.05 * shape.size, shape.high + MARGIN * shape.size)


def _cells(
    axes: Any, section: SectionFile, shape: Shape, faces: list[Any], detail: Detail | None
) -> None:
    if detail and detail.thickness < HAIR * shape.size:  # lines would cover the colour
        fill(axes, shape, facecolors=faces, edgecolors="face", linewidths=0.3)
        width = 0.2
    else:
        line = 0.1 if len(faces) > MANY_CELLS else 0.3
        fill(axes, shape, facecolors=faces, edgecolors=(1.0, 1.0, 1.0, 0.6), linewidths=line)
        width = 0.6
    borders = LineCollection(shape.borders(section.mesh.region), colors=INK, linewidths=width)
    axes.add_collection(borders, autolim=False)


def _directions(axes: Any, section: SectionFile, shape: Shape) -> None:
    """Draw y2 outside the outermost ply of every region that has a direction; name regions."""
    mesh = section.mesh
    names = len(mesh.regions) <= MOST_NAMES
    for region, name in enumerate(mesh.regions):
        outer = outer_cells(section, region)
        if not len(outer):
            continue
        middles = shape.middles[outer]
        if is_isotropic(section, int(mesh.ply[outer[0]])):
            if names:
                inside = shape.middles[mesh.region == region]
                _name(axes, inside[nearest_to_mean(inside)], plain_words(name))
            continue
        places = _places(mesh.layer_direction[outer], middles, 1.6 * ARROW * shape.size)
        for i, place in enumerate(places):
            y2 = mesh.layer_direction[outer[place]]
            y3 = normal(y2)
            foot = middles[place] + 0.028 * shape.size * y3
            _arrow(axes, foot - ARROW / 2 * shape.size * y2, foot + ARROW / 2 * shape.size * y2)
            if i == 0 and names:  # beside the tail of a vertical arrow, where there is more space
                away = 0.033 * y3 - 0.4 * ARROW * abs(y3[0]) * y2
                _name(axes, foot + shape.size * away, f"{plain_words(name)}  $y_2$", y3)


def _arrow(axes: Any, tail: Array, tip: Array) -> None:
    style = {"arrowstyle": "-|>", "color": INK, "lw": 1.0, "mutation_scale": 8}
    axes.annotate("", tip, tail, arrowprops={**style, "shrinkA": 0, "shrinkB": 0}, zorder=4)


def _name(axes: Any, place: Array, text: str, y3: Array | None = None) -> None:
    across = 0.0 if y3 is None else float(y3[0])
    side = "left" if across > 0.5 else "right" if across < -0.5 else "center"
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    axes.text(*place, text, fontsize=7.5, color=INK, ha=side, va="center", bbox=box, zorder=5)


def _places(y2: Array, points: Array, apart: float) -> list[int]:
    """Rows where a layer direction is drawn: one, or several if the direction changes."""
    first = nearest_to_mean(points)
    turn = np.arccos(np.clip(y2 @ y2[first], -1.0, 1.0))
    if turn.max() < TURNING:
        return [first]
    places = [first]
    gap = np.linalg.norm(points - points[first], axis=1)
    while len(places) < 6 and gap.max() > apart:
        places.append(int(np.argmax(gap)))
        gap = np.minimum(gap, np.linalg.norm(points - points[places[-1]], axis=1))
    return places


def _mark(marker: str, size: float) -> dict[str, Any]:
    line = {"color": "none", "markeredgecolor": WARNING, "markeredgewidth": 1.3}
    return {"marker": marker, "markersize": size, "markerfacecolor": "none", **line}


def _centre_legend(axes: Any, section: SectionFile, shape: Shape) -> None:
    axes.set_axis_off()
    handles = [Line2D([], [], marker="+", color="none", markeredgecolor=INK, markersize=13)]
    labels = ["reference point  (0, 0)"]
    for name, field, marker, size in CENTRES:
        place = shape.scale * getattr(section, field)
        place = np.where(np.abs(place) < ROUND_OFF * shape.size, 0.0, place)
        handles.append(Line2D([], [], **_mark(marker, min(size, 10.0))))
        labels.append(f"{name}  ({place[0]:.4g}, {place[1]:.4g})".replace("-", "\N{MINUS SIGN}"))
    axes.legend(
        handles,
        labels,
        title=f"Points ($x_2$, $x_3$) [{shape.unit}]",
        loc="upper left",
        title_fontsize=8.5,
        labelspacing=0.7,
        alignment="left",
        borderpad=0.0,
        borderaxespad=0.0,
    )


def _enlarged(
    axes: Any, section: SectionFile, shape: Shape, detail: Detail, faces: list[Any]
) -> None:
    fill(axes, shape, facecolors=faces, edgecolors="white", linewidths=0.4)
    borders = LineCollection(shape.borders(section.mesh.region), colors=INK, linewidths=0.9)
    axes.add_collection(borders, autolim=False)
    frame(axes, detail.low, detail.high)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set(color=INK, linewidth=0.8, linestyle=DASHED)
    for axis, name in ((detail.y2, "$y_2$"), (normal(detail.y2), "$y_3$")):
        _arrow(axes, detail.foot, detail.foot + 0.55 * detail.thickness * axis)
        place = detail.foot + 0.8 * detail.thickness * axis
        axes.text(*place, name, fontsize=8.5, color=INK, ha="center", va="center", zorder=5)


# Six panels: the stresses in a section under each unit resultant.

NORMAL = ("F1", "M2", "M3")  # shown as s11; the others as shear
SPACING = {1: 1 / 30, 2: 1 / 18, 3: 1 / 15}  # of arrows over the longer side, by columns
WEAK = 0.05  # arrows below this share of the longest are omitted
AGAINST = 0.4  # reversed flow is shown from this share of the main flow
# Values above this quantile of the area get the last colour: otherwise peaks at re-entrant corners
# make all other colours pale.
SHOWN = 0.995
NARROWEST = 0.6  # width of a panel over its height
# Dark enough on white at both ends and in the middle, and monotonic in black and white.
SHEAR = LinearSegmentedColormap.from_list("shear", ["#DCE6EE", "#6FB7C6", "#2A7F8E", "#0B3C49"])
NORMAL_SIGNED, NORMAL_TENSION, NORMAL_COMPRESSION = "RdBu_r", "Reds", "Blues_r"
PREFIXES = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"), (1e-3, "mPa"), (1e-6, "µPa"))


def draw_states(section: SectionFile, shape: Shape, path: Path) -> Path:
    """Draw the six unit states; the file appears only when it is complete.

    Parameters
    ----------
    section : results of the section
    shape : outline and cells of the section
    path : file of the picture
    """
    stress = unit_stress(section.recovery)
    field = CellField(section, shape)
    low, high = _panel_corners(shape)
    width, height = high - low
    columns = 1 if width > 5.0 * height else 2 if width > 2.2 * height else 3
    rows = 6 // columns
    tall = min(max((WIDTH / columns - 0.75) * height / width, 0.35), 3.2) + 0.45
    canvas = Canvas(WIDTH, rows * tall + 0.6)
    title = canvas.figure.suptitle(
        plain_words(section.name), x=0.012, ha="left", fontsize=11, fontweight="bold"
    )
    title.set_in_layout(True)
    canvas.figure.supxlabel(
        r"stress in section axes under one unit of each resultant: $\sigma_{11}$, and $\tau$ = "
        r"($\sigma_{12}$, $\sigma_{13}$) with arrows along it",
        x=0.012, ha="left", fontsize=8, color=GREY,
    )  # fmt: skip
    for axes, name in zip(canvas.panels(rows, columns), RESULTANTS, strict=True):
        state = stress[:, :, RESULTANTS.index(name)]
        if name in NORMAL:
            unit = _normal(axes, field, state[:, 0])
            shown = r"$\sigma_{11}$"
        else:
            unit = _shear(axes, field, state[:, [5, 4]], SPACING[columns] * shape.size)
            shown = r"$|\tau|$"
        one = "1 N m" if name.startswith("M") else "1 N"
        axes.set_title(f"${name[0]}_{name[1]}$ = {one}:  {shown} [{unit}]", fontweight="normal")
        frame(axes, low, high)
        axes.set_axis_off()
    return canvas.save(path)


def _panel_corners(shape: Shape) -> tuple[Array, Array]:
    """Corners of a panel: the section with a margin, and room for the title of a narrow one."""
    low, high = shape.low - 0.03 * shape.size, shape.high + 0.03 * shape.size
    width, height = high - low
    missing = np.array([max(0.0, NARROWEST * height - width) / 2, 0.0])
    return low - missing, high + missing


def _normal(axes: Any, field: CellField, s11: Array) -> str:
    corners = field.at_corners(s11)
    top, bottom = _top(field, s11), _top(field, -s11)
    largest = max(top, bottom)
    if bottom <= 0.02 * largest:
        return _colours(axes, field, corners, NORMAL_TENSION, 0.0, largest)
    if top <= 0.02 * largest:
        return _colours(axes, field, corners, NORMAL_COMPRESSION, -largest, 0.0)
    return _colours(axes, field, corners, NORMAL_SIGNED, -largest, largest)


def _shear(axes: Any, field: CellField, tau: Array, step: float) -> str:
    shade = np.hypot(*(field.at_corners(component) for component in tau.T))
    top = _top(field, np.linalg.norm(tau, axis=1))
    unit = _colours(axes, field, shade, SHEAR, 0.0, top)
    places, arrows = shear_flow(field, cell_means(field.section, tau), step)
    length = np.linalg.norm(arrows, axis=1)
    reach = 0.85 * step * np.sqrt(length / length.max(initial=0.0))
    heads = arrows / length[:, None] * reach[:, None]
    axes.quiver(
        *(places - heads / 2).T, *heads.T, angles="xy", scale_units="xy", scale=1.0,
        units="inches", width=0.012, headwidth=4.2, headlength=4.4, headaxislength=3.8, color=INK,
        path_effects=[withStroke(linewidth=1.1, foreground="white")], zorder=3,
    )  # fmt: skip
    return unit


def _top(field: CellField, values: Array) -> float:
    """The value that only a small share of the area exceeds."""
    order = np.argsort(values)
    share = np.cumsum(field.section.recovery.weights[order])
    return float(values[order][np.searchsorted(share, SHOWN * share[-1])])


def _colours(
    axes: Any, field: CellField, corners: Array, name: Any, low: float, high: float
) -> str:
    """Colour the section and add the colour bar; returns the unit of its numbers."""
    largest = max(abs(low), abs(high))
    factor, unit = next((p for p in PREFIXES if largest >= p[0]), PREFIXES[-1])
    shades = axes.tripcolor(
        field.triangles, corners / factor, shading="gouraud", cmap=name,
        norm=Normalize(low / factor, high / factor),
    )  # fmt: skip
    bar = axes.figure.colorbar(shades, ax=axes, shrink=0.85, aspect=16, pad=0.02)
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=7.5, length=2, color=GREY)
    return unit


def shear_flow(field: CellField, tau: Array, step: float) -> tuple[Array, Array]:
    """Positions and shear stresses of arrows with a minimum distance.

    Cells of one region in one box of a grid give an arrow at their middle. They give two if the
    flow is reversed on the other face of a wall, as in the torsion of an open section. Of two
    arrows with the same direction that are too close, the longer one is kept.

    Parameters
    ----------
    field : cells of the section, with their middles and areas
    tau : shear stress of each cell (c, 2) [Pa]
    step : least distance of arrows [m]
    """
    box = np.floor((field.middle - field.shape.low) / step).astype(np.int64)
    region = field.section.mesh.region
    _, which = np.unique(np.column_stack([region, box]), axis=0, return_inverse=True)
    which = which.ravel()
    n = int(which.max()) + 1
    tensor = np.zeros((n, 2, 2))
    np.add.at(tensor, which, field.area[:, None, None] * np.einsum("ca,cb->cab", tau, tau))
    main = np.linalg.eigh(tensor)[1][:, :, 1]  # the main direction of the flow in each box
    back = np.einsum("ca,ca->c", tau, main[which]) < 0.0
    which = which + n * back
    total = np.bincount(which, weights=field.area, minlength=2 * n)
    sums = [
        np.bincount(which, weights=field.area * values, minlength=2 * n)
        for values in (*field.middle.T, *tau.T)
    ]
    flow = np.linalg.norm(sums[2:], axis=0).reshape(2, n)
    shown = (flow > AGAINST * flow[::-1]).ravel() & (total > 0.0)
    columns = np.stack(sums, axis=1)[shown] / total[shown, None]
    places, arrows = columns[:, :2], columns[:, 2:]
    length = np.linalg.norm(arrows, axis=1)
    kept: list[int] = []
    for i in np.argsort(-length):
        if length[i] <= WEAK * length.max():
            break
        close = np.linalg.norm(places[kept] - places[i], axis=1) < 0.8 * step
        if not np.any(close & (arrows[kept] @ arrows[i] > 0.0)):
            kept.append(int(i))
    return places[kept], arrows[kept]


# Figures of a section: the mesh with the plies, and the stresses under unit resultants.


def draw_section(section: SectionFile, folder: Path) -> list[Path]:
    """Write <name>-mesh.png and <name>-states.png into a folder; returns their paths.

    Raises InputError without matplotlib.
    """
    stem = re.sub(r"[^\w.+-]+", "-", section.name).strip("-.") or "section"
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    shape = shape_of(section.mesh)
    with house_style(formulas=True):
        return [
            draw_mesh(section, shape, folder / f"{stem}-mesh.png"),
            draw_states(section, shape, folder / f"{stem}-states.png"),
        ]
