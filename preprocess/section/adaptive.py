"""Where the error of a section sits, and which cells are refined to reduce it."""

import numpy as np
from numpy.typing import NDArray

from ...solver.math.arrays import Array
from .helical import CentralSolutions
from .problem import SectionProblem
from .recovery import unit_strains
from .space import SectionSpace
from .timoshenko import SectionStiffness

Result = SectionStiffness | CentralSolutions

SHARE = 0.85  # of the error that the refined cells hold


def indicators(
    problem: SectionProblem, result: Result, richer: SectionProblem, better: Result, C: Array
) -> Array:
    """Energy of the error in each cell under the six unit resultants, relative, summed, (c,).

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
    )
    if result.space.over is not None:
        points = points.expressed(result.space.over)
    difference = unit_strains(better.space, better) - unit_strains(points, result)
    density = np.einsum("cqim,cqim->cqm", difference, C @ difference)
    energy = np.einsum("cq,cqm->cm", points.weights, density)
    size = np.diag(np.linalg.inv(better.K))
    return np.asarray((energy / size).sum(axis=1))


def worst_cells(error: Array, share: float = SHARE) -> NDArray[np.bool_]:
    """The fewest cells that hold this share of the error, (c,)."""
    order = np.argsort(error)[::-1]
    held = np.cumsum(error[order])
    count = int(np.searchsorted(held, share * held[-1])) + 1
    marked = np.zeros(len(error), dtype=bool)
    marked[order[:count]] = True
    return marked
