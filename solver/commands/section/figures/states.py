"""Six panels: the stresses in a section under each unit resultant."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.patheffects import withStroke

from ....math.arrays import Array
from ....package.section.schema import RESULTANTS, SectionFile
from ....package.section.stress import cell_means, unit_stress
from ....report.style import GREY, INK, Canvas, plain_words
from .cell_field import CellField
from .drawing import Shape, frame

NORMAL = ("F1", "M2", "M3")  # shown as s11; the others as shear
SPACING = {1: 1 / 30, 2: 1 / 18, 3: 1 / 15}  # of arrows over the longer side, by columns
WEAK = 0.05  # arrows below this share of the longest are omitted
AGAINST = 0.4  # reversed flow is shown from this share of the main flow
# Values above this quantile of the area get the last colour: otherwise peaks at re-entrant corners
# make all other colours pale.
SHOWN = 0.995
WIDTH = 8.0  # inches
NARROWEST = 0.6  # width of a panel over its height
# Dark enough on white at both ends and in the middle, and monotonic in black and white.
SHEAR = LinearSegmentedColormap.from_list("shear", ["#DCE6EE", "#6FB7C6", "#2A7F8E", "#0B3C49"])
NORMAL_SIGNED, NORMAL_TENSION, NORMAL_COMPRESSION = "RdBu_r", "Reds", "Blues_r"
PREFIXES = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"), (1e-3, "mPa"), (1e-6, "µPa"))


def draw_states(section: SectionFile, shape: Shape, path: Path) -> Path:
    """Draw the six unit states; the file appears only when it is complete."""
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
