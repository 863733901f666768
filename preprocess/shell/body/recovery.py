"""Stress recovery data of a shell for its package: resultants of the modes, and laminates."""

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.body.schema import CellResultants, LaminateData
from ....solver.package.section.stress import rounded
from ..model.problem import ShellProblem
from ..model.regions import cell_axes


def cell_resultants(problem: ShellProblem, u: Array) -> CellResultants:
    """Mean resultants of every cell per unit mode, in the order of the mesh file.

    They are rounded like the recovery of sections, which halves the size of the compressed data.

    Parameters
    ----------
    u : (n_dof, m) motion of all degrees of freedom
    """
    mesh = problem.mesh
    laminate = np.empty(len(mesh.cells), dtype=np.int64)
    names = _laminate_names(problem)
    for region in problem.regions:
        laminate[region.cells] = names.index(region.laminate_name)
    found = problem.resultants(u)
    return CellResultants(
        cell=np.arange(len(mesh.cells)),
        laminate=laminate,
        A_BE=cell_axes(mesh, problem.regions),
        resultants_E=rounded(np.ascontiguousarray(np.moveaxis(found, 0, 2))),
    )


def laminates(problem: ShellProblem) -> tuple[LaminateData, ...]:
    """Every laminate that a region uses, once."""
    found: dict[str, LaminateData] = {}
    for region in problem.regions:
        name = region.laminate_name
        if name not in found:
            constants = problem.spec["materials"]
            found[name] = region.laminate.data(name, region.stiffness, constants)
    return tuple(found.values())


def _laminate_names(problem: ShellProblem) -> list[str]:
    return list(dict.fromkeys(region.laminate_name for region in problem.regions))
