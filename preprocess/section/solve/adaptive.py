"""Where the error of a section sits, and which cells are refined to reduce it."""

import numpy as np
from numpy.typing import NDArray

from ....solver.math.arrays import Array
from ..space.space import SectionSpace
from .helical import CentralSolutions
from .problem import SectionProblem
from .recovery import unit_strains
from .timoshenko import SectionStiffness

Result = SectionStiffness | CentralSolutions

SHARE = 0.85  # of the error that the refined cells hold


def error_energy(
    problem: SectionProblem, result: Result, richer: SectionProblem, better: Result, C: Array
) -> Array:
    """Energy of the error in each cell under pairs of the six unit resultants, (c, 6, 6) [1/K].

    The difference of the solutions with this degree and one more, on the same mesh.

    Parameters
    ----------
    problem, result : with the degree of the field
    richer, better : with one degree more
    C : (c, 1 or q, 6, 6) stiffness at the points of `richer` [Pa]
    """
    points = SectionSpace(
        problem.mesh.cells,
        problem.degree,
        richer.space.quadrature_degree,
        problem.team,
    )
    if result.space.over is not None:
        points = points.expressed(result.space.over)
    difference = unit_strains(better.space, better) - unit_strains(points, result)
    own = points.own
    stress = C[own] @ difference
    energy = np.einsum("cq,cqim,cqin->cmn", points.weights[own], difference, stress, optimize=True)
    return problem.team.stacked(energy)


def relative(energy: Array, K: Array) -> Array:
    """Energy of each cell under the six unit resultants, relative to that of the section, summed.

    `energy` (c, 6, 6), see `error_energy`; K (6, 6).
    """
    size = np.diag(np.linalg.inv(K))
    return np.asarray((np.einsum("cmm->cm", energy) / size).sum(axis=1))


def worst_cells(error: Array, share: float = SHARE) -> NDArray[np.bool_]:
    """The fewest cells that hold this share of the error, (c,)."""
    order = np.argsort(error)[::-1]
    held = np.cumsum(error[order])
    count = int(np.searchsorted(held, share * held[-1])) + 1
    marked = np.zeros(len(error), dtype=bool)
    marked[order[:count]] = True
    return marked
