"""Error estimate of K by a solution on the same mesh with one degree more, and of its edges."""

import numpy as np

from ....solver.math.arrays import Array
from ...fenicsx import EDGES
from ..mesh.cells import CORNERS, KINDS, CellMesh

# The error of K falls with the degree of the field, at least with degree^-RATE. This is the rate
# for singular stresses at the edge of a ply or a re-entrant corner; smooth parts converge faster,
# stronger singularities, as between stiff and soft quarters, more slowly (singular.py).
# docs/sections-accuracy.md compares the estimates with true errors.
RATE = 2.1
REGULAR = RATE / 4.0  # exponent lambda of the displacement that has this rate


def singular_error(K: Array, energy: Array, exponents: Array, degree: int) -> Array:
    """What `error_estimate` lacks of the error near singular points, (6, 6), in units of K.

    Parameters
    ----------
    energy : (c, 6, 6) of the difference to one degree more, under pairs of unit resultants
    exponents : (c,) lambda of the strongest singularity at each cell, REGULAR at most
    """
    # flexibilities add up, stiffnesses do not: an error may be larger than the stiffness itself
    S, usual = np.linalg.inv(K), _removed(degree)
    # the parts of the degrees above p, j^(-4 lambda - 1), add up to (p + 1/2)^(-4 lambda)
    singular = 1.0 - ((degree + 0.5) / (degree + 1.5)) ** (4.0 * exponents)
    counted = energy.sum(axis=0) / usual
    share = np.where(exponents < REGULAR, singular, usual)
    whole = np.einsum("c,cij->ij", 1.0 / share, energy)
    return np.abs(np.linalg.inv(S + counted) - np.linalg.inv(S + whole))


def error_estimate(K: Array, K_richer: Array, degree: int) -> Array:
    """Expected |error| of each entry of K (6, 6), in its units.

    `K` belongs to a field of some degree, `K_richer` to one degree more on the same mesh. With
    errors proportional to degree^-RATE, their difference is a known fraction of the error of K.
    """
    return np.abs(K - K_richer) / _removed(degree)


def error_of_edges(mesh: CellMesh, modulus: Array) -> float:
    """Error of K, scaled by sqrt(K_ii K_jj), because curved edges are parabolas and not arcs.

    A parabola through the ends and the middle of an arc of angle 2 phi has the radius
    R (1 - a^2 s^2 (1 - s^2) / 2), a = 1 - cos phi, -1 < s < 1: a^2 / 15 too small on average. The
    cell inside the arc lacks this area, the one outside has it too much. Of the axial stiffness and
    its second moments about the origin, to which K refers, the one that changes most counts.

    Parameters
    ----------
    modulus : (c,) Young's modulus of the cells along the beam [Pa]
    """
    places, size = mesh.middles, np.zeros(mesh.n_cell)
    corner = np.zeros((mesh.n_cell, 2))  # mean of the squares of the corners' distances
    own: list[Array] = []
    at_edges: list[Array] = []
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        edges = np.array(EDGES[KINDS[kind]])
        ends, middles = shape[:, edges], shape[:, CORNERS[kind] : CORNERS[kind] + len(edges)]
        chord, bow = ends[:, :, 1] - ends[:, :, 0], middles - ends.mean(axis=2)
        half, rise = 0.25 * np.sum(chord**2, axis=-1), np.sum(bow**2, axis=-1)
        a = 2.0 * rise / (half + rise)
        # arc of length 2 R phi, times R a^2 / 15; a straight edge has no radius
        R = 0.5 * (half + rise) / np.sqrt(np.where(rise > 0.0, rise, 1.0))
        sliver = 2.0 * R**2 * np.arccos(1.0 - a) * a**2 / 15.0
        outward = chord[..., 1] * bow[..., 0] - chord[..., 0] * bow[..., 1]
        sliver *= np.where(rise > 0.0, np.sign(outward), 0.0)
        corners = shape[:, : CORNERS[kind]]
        following = np.roll(corners, -1, axis=1)
        size[rows] = 0.5 * np.sum(
            corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0], axis=1
        )
        corner[rows] = np.mean((corners - places[rows, None]) ** 2, axis=1)
        own.append((sliver * modulus[rows, None]).ravel())
        at_edges.append(middles.reshape(-1, 2))
    lost, where = np.concatenate(own), np.concatenate(at_edges)
    weight = modulus * size
    share = [lost.sum() / weight.sum()]
    # second moment of a rectangle about its middle: a third of that of its corners
    share += list(lost @ where**2 / (weight @ (places**2 + corner / 3.0)))
    return float(np.abs(share).max())


def _removed(degree: int) -> float:
    """Share of an error proportional to degree^-RATE that one degree more removes."""
    return 1.0 - float((degree / (degree + 1.0)) ** RATE)


def scaled(difference: Array, K: Array) -> Array:
    """Entries in units of sqrt(K_ii K_jj), (6, 6): relative errors in any unit of length."""
    size = np.sqrt(np.abs(np.diag(K)))
    return np.abs(difference) / np.outer(size, size)
