"""Window that shows a part of a thin-walled section enlarged."""

from dataclasses import dataclass

import numpy as np

from ....math.arrays import Array, IntArray
from ....package.section.schema import SectionFile
from .drawing import Shape
from .ply_colours import is_isotropic

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
