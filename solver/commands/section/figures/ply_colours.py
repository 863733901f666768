"""Colours of plies, and the legend that explains them."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.legend_handler import HandlerBase
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from ....package.section.schema import SectionFile
from ....report.style import COLOURS, GREY, INK, plain_words

DARKEST, LIGHTEST, ALONE = 0.15, 0.74, 0.45  # share of white in the shades of one material
MOST = 14  # plies named in the legend


@dataclass(frozen=True)
class PlyColour:
    """Plies of one material and angle share a colour."""

    material: str
    angle_deg: float | None  # None: the material is isotropic
    colour: tuple[float, float, float]

    @property
    def label(self) -> str:
        """Material and angle."""
        if self.angle_deg is None:
            return self.material
        sign = "+" if self.angle_deg > 0 else "\N{MINUS SIGN}" if self.angle_deg < 0 else ""
        return f"{self.material}  {sign}{abs(self.angle_deg):.4g}°"


def is_isotropic(section: SectionFile, ply: int | np.integer[Any]) -> bool:
    """True if the material of a ply is isotropic: its angle has no meaning."""
    material = section.recovery.materials[section.recovery.plies[ply].material]
    return material.get("kind") == "isotropic"


def ply_colours(section: SectionFile) -> tuple[list[PlyColour], list[int]]:
    """Colours, a hue for each material and a shade for each angle; and the row of each ply."""
    plies = section.recovery.plies
    keys = [
        (ply.material, None if is_isotropic(section, row) else ply.angle_deg)
        for row, ply in enumerate(plies)
    ]
    found: dict[tuple[str, float | None], PlyColour] = {}
    for index, material in enumerate(dict.fromkeys(ply.material for ply in plies)):
        hue = np.array(to_rgb(COLOURS[index % (len(COLOURS) - 1)]))  # the last one is black
        angles = sorted({a for m, a in keys if m == material}, key=lambda a: (abs(a or 0), a or 0))
        shades = [ALONE] if len(angles) == 1 else np.linspace(DARKEST, LIGHTEST, len(angles))
        for angle, white in zip(angles, shades, strict=True):
            red, green, blue = (hue + (1.0 - hue) * white).tolist()
            found[material, angle] = PlyColour(material, angle, (red, green, blue))
    order = list(found)
    return list(found.values()), [order.index(key) for key in keys]


class _FibreHandler(HandlerBase):
    """A patch of the legend with the fibre drawn on it: x1 to the right, y2 up."""

    def create_artists(
        self,
        legend: Any,
        orig_handle: Any,
        xdescent: float,
        ydescent: float,
        width: float,
        height: float,
        fontsize: float,
        trans: Any,
    ) -> list[Any]:
        colour: PlyColour = orig_handle
        low = (-xdescent, -ydescent)
        patch = Rectangle(low, width, height, fc=colour.colour, ec=INK, lw=0.4, transform=trans)
        if colour.angle_deg is None:
            return [patch]
        angle = math.radians(colour.angle_deg)
        c, s = math.cos(angle), math.sin(angle)
        reach = 0.42 * min(width / max(abs(c), 1e-9), height / max(abs(s), 1e-9))
        x, y = low[0] + width / 2, low[1] + height / 2
        ends = [x - reach * c, x + reach * c], [y - reach * s, y + reach * s]
        return [patch, Line2D(*ends, color=INK, lw=1.1, transform=trans)]


def ply_legend(axes: Any, colours: list[PlyColour]) -> None:
    """Fill axes with the legend of the plies."""
    axes.set_axis_off()
    shown = colours if len(colours) <= MOST else colours[: MOST - 1]
    oriented = any(colour.angle_deg is not None for colour in shown)
    axes.legend(
        shown,
        [plain_words(colour.label) for colour in shown],
        handler_map={PlyColour: _FibreHandler()},
        title="Plies: fibre from $x_1$ (right) to $y_2$ (up)" if oriented else "Materials",
        loc="upper left",
        title_fontsize=8.5,
        handlelength=2.2,
        handleheight=1.4,
        alignment="left",
        borderpad=0.0,
        borderaxespad=0.0,
        ncols=1 if len(shown) <= 7 else 2,
    )
    if len(shown) < len(colours):
        rest = f"and {len(colours) - len(shown)} more"
        axes.annotate(rest, (0, 0), xycoords="axes fraction", fontsize=8, color=GREY)
