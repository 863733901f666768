"""Error estimate of K by a solution on the same mesh with one degree more, and of its edges."""

import numpy as np

from ...solver.math.arrays import Array
from ..fenicsx import EDGES
from .cells import CORNERS, KINDS, CellMesh

# The error of K falls with the degree of the field, at least with degree^-RATE. This is the rate
# for singular stresses (at the edge of a ply or a re-entrant corner); smooth parts converge
# faster. docs/sections-accuracy.md compares the estimates with true errors.
RATE = 2.1


def error_estimate(K: Array, K_richer: Array, degree: int) -> Array:
    """Expected |error| of each entry of K (6, 6), in its units.

    `K` belongs to a field of some degree, `K_richer` to one degree more on the same mesh. With
    errors proportional to degree^-RATE, their difference is a known fraction of the error of K.
    """
    share = 1.0 - (degree / (degree + 1.0)) ** RATE
    return np.abs(K - K_richer) / share


def error_of_edges(mesh: CellMesh) -> float:
    """Error of K, scaled by sqrt(K_ii K_jj), because curved edges are parabolas and not arcs.

    A parabola through the ends and the middle of an arc of angle 2 phi has the radius
    R (1 - a^2 s^2 (1 - s^2) / 2), a = 1 - cos phi, -1 < s < 1: a^2 / 15 too small on average. Areas
    are wrong by twice, second moments of areas by four times this share.
    """
    total, weighted = 0.0, 0.0
    for (kind, _), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        edges = np.array(EDGES[KINDS[kind]])
        ends, middles = shape[:, edges], shape[:, CORNERS[kind] : CORNERS[kind] + len(edges)]
        half = 0.25 * np.sum((ends[:, :, 1] - ends[:, :, 0]) ** 2, axis=-1)
        bow = np.sum((middles - ends.mean(axis=2)) ** 2, axis=-1)
        a = (2.0 * bow / (half + bow)).max(axis=1)
        corners = shape[:, : CORNERS[kind]]
        following = np.roll(corners, -1, axis=1)
        area = 0.5 * np.sum(
            corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0], axis=1
        )
        total, weighted = total + area.sum(), weighted + area @ a**2
    return 4.0 / 15.0 * float(weighted / total)


def scaled(difference: Array, K: Array) -> Array:
    """Entries in units of sqrt(K_ii K_jj), (6, 6): relative errors in any unit of length."""
    size = np.sqrt(np.abs(np.diag(K)))
    return np.abs(difference) / np.outer(size, size)
