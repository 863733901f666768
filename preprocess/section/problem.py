"""A section's mesh with all data that do not depend on material, kept for all lay-ups."""

from collections.abc import Mapping
from functools import cached_property, lru_cache
from typing import Any

from ...solver.math.arrays import Array
from .. import fenicsx
from .errors import SectionError
from .mesh import SectionMesh, section_mesh
from .operators import SectionOperators
from .space import SectionSpace
from .timoshenko import SectionStiffness, stiffness
from .warping import WarpingSolver

KEPT = 8  # meshes (and degrees) that a process keeps


class SectionProblem:
    """The warping problem of a mesh at one degree of the field."""

    def __init__(self, mesh: SectionMesh, degree: int, team: fenicsx.Team = fenicsx.ALONE) -> None:
        self.mesh = mesh
        self.space = SectionSpace(mesh.labelled, degree)
        self.team = team
        self.operators = SectionOperators(self.space, team)

    @cached_property
    def solver(self) -> WarpingSolver:
        """Solver that keeps the pattern without pins and the symbolic factorisation."""
        return WarpingSolver(self.space, team=self.team)

    def solve(self, C: Array) -> SectionStiffness:
        """The 6x6 stiffness for given stiffness at the points, (c, 1 or q, 6, 6) [Pa]."""
        return stiffness(self.space, self.solver, self.operators.E(C), C)


def section_problem(
    mesh_spec: Mapping[str, Any],
    where: str,
    degree: int,
    refine: int = 0,
    team: fenicsx.Team = fenicsx.ALONE,
) -> SectionProblem:
    """The problem on the mesh of a description, refined uniformly `refine` times.

    Raises SectionError if the degree of the field is below that of the geometry.
    """
    mesh = section_mesh(mesh_spec, where, refine=refine)
    _, _, of_geometry = fenicsx.geometry(mesh.labelled.mesh)
    if degree < of_geometry:
        raise SectionError(
            f"{where}.mesh.degree = {degree}: expected at least {of_geometry}, the degree of the "
            "mesh: a lower field cannot follow its curved edges"
        )
    return _kept(mesh, degree, team)


@lru_cache(maxsize=KEPT)
def _kept(mesh: SectionMesh, degree: int, team: fenicsx.Team) -> SectionProblem:
    return SectionProblem(mesh, degree, team)
