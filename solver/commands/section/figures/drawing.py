"""Common parts of both figures of a section: cells as polygons, size, axes in mm or m."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection

from ....math.arrays import Array, IntArray
from ....package.section.schema import SectionMeshData

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
    """Add the cells to axes; `array=` colours them by value, `facecolors=` by name."""
    collection = PolyCollection(shape.polygons, **style)
    axes.add_collection(collection, autolim=False)
    return collection


def frame(axes: Any, low: Array, high: Array) -> None:
    """Show a rectangle with equal scales of both axes."""
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.grid(visible=False)
