"""Spheres on the surface of a body, which stand for point masses."""

from collections.abc import Sequence

import numpy as np

from ..math.arrays import Array, IntArray
from .surfaces import Parts
from .view import Surface

SIDES = 12  # of the equator
_BANDS = SIDES // 2
DENSITY = 7850.0  # of the sphere, steel [kg/m3]
LEAST, MOST = 0.012, 0.05  # radius over the size of the mechanism

Ball = tuple[Array, float]  # centre (3,) in body axes [m], mass [kg]


def radius(mass: float, reach: float) -> float:
    """Return the radius [m] of a steel sphere of this mass, in bounds of the picture."""
    of_steel = (3.0 * mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0)
    return float(np.clip(of_steel, LEAST * reach, MOST * reach)) if reach > 0.0 else of_steel


def with_spheres(surface: Surface, nodes_B: Array, balls: Sequence[Ball], reach: float) -> Surface:
    """Return a surface and a sphere for each point mass, moving with the node nearest to it.

    Parameters
    ----------
    nodes_B : (n, 3) nodes of the body [m]
    reach : size of the mechanism [m]
    """
    parts = Parts()
    parts.points(surface.node, surface.offset_B)
    parts.triangles(surface.triangles, surface.edges, surface.site)
    rings, quads = _unit_sphere()
    for centre, mass in balls:
        node = int(np.argmin(np.linalg.norm(nodes_B - centre, axis=1)))
        points = centre - nodes_B[node] + radius(mass, reach) * rings
        first = parts.points(np.full(len(points), node), points)
        parts.quads(first + quads, np.full(quads.shape, -1), sides=0)
    return parts.surface()


def _unit_sphere() -> tuple[Array, IntArray]:
    """Points (p, 3) on circles of latitude, poles included, and cells (f, 4), outward."""
    polar = np.linspace(0.0, np.pi, _BANDS + 1)[:, None]
    around = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)[None, :]
    x, y = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around)
    points = np.stack([x, y, np.cos(polar) * np.ones_like(around)], axis=-1).reshape(-1, 3)
    band, side = np.meshgrid(np.arange(_BANDS), np.arange(SIDES), indexing="ij")
    next_side = (side + 1) % SIDES
    corners = [(band, side), (band + 1, side), (band + 1, next_side), (band, next_side)]
    cells = np.stack([b * SIDES + s for b, s in corners], axis=-1).reshape(-1, 4)
    return points, cells.astype(np.int64)
