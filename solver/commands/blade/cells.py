"""Nodes and cells of a station."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...errors import InputError
from ...math.arrays import Array
from .wall import Band


@dataclass
class StationMesh:
    """Nodes and cells of a station.

    Attributes
    ----------
    nodes : [x2, x3] [m]
    cells : node numbers of triangles and quadrilaterals, counter-clockwise
    regions : name of the layer of each cell
    bands : the layers by name
    outer : edges of the outer surface of the shell
    directions : layer direction of regions that are not of the shell
    removed : share of the area of layers for which the contour has no room
    """

    nodes: list[tuple[float, float]] = field(default_factory=list)
    cells: list[tuple[int, ...]] = field(default_factory=list)
    regions: list[str] = field(default_factory=list)
    outer: list[tuple[int, int]] = field(default_factory=list)
    bands: dict[str, Band] = field(default_factory=dict)
    directions: dict[str, tuple[float, float]] = field(default_factory=dict)
    removed: float = 0.0

    def node(self, point: Array) -> int:
        """Add a node; its number."""
        self.nodes.append((float(point[0]), float(point[1])))
        return len(self.nodes) - 1

    def cell(self, corners: Sequence[int], band: Band) -> None:
        """Add a cell of three or four different corners, in any sense of rotation, of a layer.

        Raises
        ------
        InputError : the region of this name belongs to another layer.
        """
        if self.bands.setdefault(band.name, band) != band:
            raise InputError(
                f"structure.layers: {band.name!r} is also a region of the station; expected "
                "another name of the layer"
            )
        found = list(dict.fromkeys(corners))
        if len(found) < 3:
            return
        if enclosed(np.array([self.nodes[k] for k in found])) < 0.0:
            found.reverse()
        self.cells.append(tuple(found))
        self.regions.append(band.name)


def enclosed(corners: Array) -> float:
    """Twice the area of a polygon of corners (n, 2), negative if they are clockwise [m2]."""
    x, y = corners, np.roll(corners, -1, axis=0)
    return float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum())
