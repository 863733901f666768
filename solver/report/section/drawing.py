"""Common parts of the figures of a section: cells, axes, colours of plies, enlarged windows."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.legend_handler import HandlerBase
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.tri import Triangulation

from ...math.arrays import Array, IntArray
from ...package.section.section_schema import SectionFile, SectionMeshData
from ...package.section.stress import cell_means
from ..style import COLOURS, GREY, INK, plain_words

# Common parts of both figures of a section: cells as polygons, size, axes in mm or m.

# Corner and edge nodes of a cell in order around it, by VTK cell type, and their number on a side.
_OUTLINE = {
    5: ((0, 1, 2), 1),
    9: ((0, 1, 2, 3), 1),
    22: ((0, 3, 1, 4, 2, 5), 2),
    23: ((0, 4, 1, 5, 2, 6, 3, 7), 2),
    28: ((0, 4, 1, 5, 2, 6, 3, 7), 2),
}


@dataclass(frozen=True)
class Shape:
    """Data to draw a section; lengths in `unit`."""

    polygons: list[Array]  # one for each cell, (corners, 2)
    sides: list[Array]  # of all cells, (2 or 3, 2)
    neighbours: IntArray  # (sides, 2) cells on both sides, -1 outside
    middles: Array  # (c, 2) of the cells
    low: Array  # (2,) lower left corner of the mesh
    high: Array  # (2,) upper right corner
    unit: str  # mm or m
    scale: float  # unit per metre

    @property
    def size(self) -> float:
        """The longer side of the mesh."""
        return float(np.max(self.high - self.low))

    def borders(self, label: IntArray) -> list[Array]:
        """Sides between cells of different labels (c,), and those of the outer edge."""
        one, other = self.neighbours.T
        apart = (other < 0) | (label[one] != label[other])
        return [self.sides[i] for i in np.flatnonzero(apart)]


def shape_of(mesh: SectionMeshData) -> Shape:
    """Return the cells of a mesh as polygons through their corner and edge nodes."""
    extent = float(np.ptp(mesh.nodes, axis=0).max())
    unit, scale = ("mm", 1e3) if extent < 1.0 else ("m", 1.0)
    nodes = scale * mesh.nodes
    polygons: list[Array] = [np.empty((0, 2))] * len(mesh.cell_types)
    ends, lines, owners = [], [], []
    for kind in np.unique(mesh.cell_types):
        turn, step = _OUTLINE[int(kind)]
        cells = np.flatnonzero(mesh.cell_types == kind)
        rows = mesh.connectivity[mesh.offsets[cells][:, None] + np.array(turn)]
        for cell, corners in zip(cells, nodes[rows], strict=True):
            polygons[cell] = corners
        for first in range(0, len(turn), step):
            side = rows[:, [(first + i) % len(turn) for i in range(step + 1)]]
            ends.append(np.sort(side[:, [0, -1]], axis=1))
            lines.extend(nodes[side])
            owners.append(cells)
    _, seen, which = np.unique(np.concatenate(ends), axis=0, return_index=True, return_inverse=True)
    owner = np.concatenate(owners)
    neighbours = np.full((len(seen), 2), -1)
    neighbours[:, 0] = owner[seen]
    later = np.ones(len(owner), dtype=bool)
    later[seen] = False
    neighbours[which.ravel()[later], 1] = owner[later]
    return Shape(
        polygons=polygons,
        sides=[lines[i] for i in seen],
        neighbours=neighbours,
        middles=np.array([polygon.mean(axis=0) for polygon in polygons]),
        low=nodes.min(axis=0),
        high=nodes.max(axis=0),
        unit=unit,
        scale=scale,
    )


def fill(axes: Any, shape: Shape, **style: Any) -> PolyCollection:
    """Add the cells to axes; `array=` colours them by value, `facecolors=` by name.

    Parameters
    ----------
    axes : axes of matplotlib
    shape : outline and cells
    style : options of matplotlib's PolyCollection
    """
    collection = PolyCollection(shape.polygons, **style)
    axes.add_collection(collection, autolim=False)
    return collection


def frame(axes: Any, low: Array, high: Array) -> None:
    """Show a rectangle with equal scales of both axes.

    Parameters
    ----------
    axes : axes of matplotlib
    low : lower left corner (2,) [m]
    high : upper right corner (2,) [m]
    """
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.grid(visible=False)


# Values at integration points as shades of the cells.


class CellField:
    """Values at the integration points as a polynomial in every cell, and its cells as triangles.

    The polynomial has degree 2, or 1 in a cell with more than one ply.
    """

    def __init__(self, section: SectionFile, shape: Shape) -> None:
        self.section, self.shape = section, shape
        recovery = section.recovery
        self.area = np.bincount(recovery.cell, weights=recovery.weights)
        self.middle = cell_means(section, shape.scale * recovery.points)
        arm = shape.scale * recovery.points - self.middle[recovery.cell]
        self.reach = np.sqrt(cell_means(section, (arm**2).sum(axis=1)))
        self.basis = _monomials(arm / self.reach[recovery.cell, None])
        gram = cell_means(section, np.einsum("pi,pj->pij", self.basis, self.basis))
        other = recovery.ply != section.mesh.ply[recovery.cell]
        several = cell_means(section, other.astype(float)) > 0.0
        gram[several, 3:] = gram[several, :, 3:] = 0.0
        self.solve = np.linalg.pinv(gram, hermitian=True)
        # a fan of triangles about the middle of each cell; cells have no common points
        points, triangles, cells = [], [], []
        start = 0
        for cell, polygon in enumerate(shape.polygons):
            n = len(polygon)
            ring = start + 1 + np.arange(n)
            points += [polygon.mean(axis=0)[None], polygon]
            triangles.append(np.column_stack([np.full(n, start), ring, np.roll(ring, -1)]))
            cells += [cell] * (n + 1)
            start += n + 1
        self.corners_at, self.cells = np.concatenate(points), np.array(cells)
        x2, x3 = self.corners_at.T
        self.triangles = Triangulation(x2, x3, np.concatenate(triangles))
        self.corners = _monomials(
            (self.corners_at - self.middle[self.cells]) / self.reach[self.cells, None]
        )

    def at_corners(self, values: Array) -> Array:
        """Values of the least-squares polynomials at the corners of the triangles."""
        load = cell_means(self.section, values[:, None] * self.basis)
        factors = np.einsum("cij,cj->ci", self.solve, load)
        return np.einsum("ni,ni->n", factors[self.cells], self.corners)


def _monomials(x: Array) -> Array:
    a, b = x.T
    return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)


# Window that shows a part of a thin-walled section enlarged.

THIN = 0.12  # walls below this share of the section's size are shown enlarged
GAP = 2.5  # a step in depth above this many cells ends the wall
HALF = 2.1  # half of the window's side, in thicknesses of the wall


@dataclass(frozen=True)
class Detail:
    """A square window at a corner, in the unit of the drawing."""

    low: Array  # (2,)
    high: Array  # (2,)
    foot: Array  # (2,) where the layer's axes are drawn, outside the wall
    y2: Array  # (2,) layer direction there
    thickness: float  # of the wall


def outer_cells(section: SectionFile, region: int) -> IntArray:
    """Cells of a region's outermost ply."""
    mesh, plies = section.mesh, section.recovery.plies
    cells = np.flatnonzero(mesh.region == region)
    depth = np.array([plies[ply].index for ply in mesh.ply[cells]])
    return cells[depth == depth.min(initial=0)]


def nearest_to_mean(points: Array) -> int:
    """Row of the point that is nearest to the mean of all."""
    return int(np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1)))


def normal(y2: Array) -> Array:
    """Outward normal y3 = x1 x y2 of a layer direction, in x2 and x3."""
    return np.array([-y2[1], y2[0]])


def detail_of(section: SectionFile, shape: Shape) -> Detail | None:
    """Return a window where regions of thin walls meet, or at an outer corner.

    None for thick sections, and for a section of one material without layers.
    """
    mesh = section.mesh
    node, n_region = _meeting_node(section, shape)
    outer = np.concatenate([outer_cells(section, row) for row in range(len(mesh.regions))])
    corner = int(outer[np.argmin(np.linalg.norm(shape.middles[outer] - node, axis=1))])
    region = int(mesh.region[corner])
    if np.ptp(mesh.ply[mesh.region == region]) == 0 and is_isotropic(section, mesh.ply[corner]):
        return None
    wall = outer_cells(section, region)
    at = int(wall[nearest_to_mean(shape.middles[wall])])
    thickness = _thickness(section, shape, at)
    if thickness > THIN * shape.size:
        return None
    y2 = mesh.layer_direction[corner]
    foot = shape.middles[corner] + thickness * (0.45 * normal(y2) - 0.9 * y2)
    if n_region == 2:  # two walls: the corner, and more of what is below and beside it
        centre = node - np.array([0.9, 0.5]) * thickness
    else:
        centre = (foot if n_region == 1 else node) + 0.2 * thickness * normal(y2)
    half = HALF * thickness
    return Detail(centre - half, centre + half, foot, y2, thickness)


def _meeting_node(section: SectionFile, shape: Shape) -> tuple[Array, int]:
    """A node where the most regions meet (the upper right one of several), and their number."""
    mesh = section.mesh
    region = np.repeat(mesh.region, np.diff(mesh.offsets))
    pairs = np.unique(np.column_stack([mesh.connectivity, region]), axis=0)
    count = np.bincount(pairs[:, 0], minlength=len(mesh.nodes))
    nodes = shape.scale * mesh.nodes
    # not exactly diagonal, so that the choice between two equal corners is unique
    score = np.where(count == count.max(), nodes @ np.array([0.8, 1.0]), -np.inf)
    return nodes[int(np.argmax(score))], int(count.max())


def _thickness(section: SectionFile, shape: Shape, cell: int) -> float:
    """Depth of the wall below a cell of its outer face."""
    mesh = section.mesh
    y2 = mesh.layer_direction[cell]
    inward = -normal(y2)
    offset = shape.middles - shape.middles[cell]
    below = np.abs(offset @ y2) <= 0.6 * np.ptp(shape.polygons[cell] @ y2)
    below &= (mesh.region == mesh.region[cell]) & (offset @ inward > -1e-9 * shape.size)
    stack = np.flatnonzero(below)
    stack = stack[np.argsort(offset[stack] @ inward)]
    face = bottom = float((shape.polygons[cell] @ inward).min())
    for below_it in stack:
        depth = shape.polygons[below_it] @ inward
        if depth.min() - bottom > GAP * np.ptp(depth):
            break
        bottom = max(bottom, float(depth.max()))
    return bottom - face


# Colours of plies, and the legend that explains them.

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
    colours: dict[tuple[str, float | None], PlyColour] = {}
    for index, material in enumerate(dict.fromkeys(ply.material for ply in plies)):
        hue = np.array(to_rgb(COLOURS[index % (len(COLOURS) - 1)]))  # the last one is black
        angles = sorted({a for m, a in keys if m == material}, key=lambda a: (abs(a or 0), a or 0))
        shades = [ALONE] if len(angles) == 1 else np.linspace(DARKEST, LIGHTEST, len(angles))
        for angle, white in zip(angles, shades, strict=True):
            red, green, blue = (hue + (1.0 - hue) * white).tolist()
            colours[material, angle] = PlyColour(material, angle, (red, green, blue))
    order = list(colours)
    return list(colours.values()), [order.index(key) for key in keys]


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
