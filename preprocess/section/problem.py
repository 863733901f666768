"""A section's mesh with all data that do not depend on material, kept for all lay-ups."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ...solver.math.arrays import Array
from .. import fenicsx
from .end_effects import end_compliance
from .errors import SectionError
from .estimate import scaled
from .helical import CentralSolutions, central_solutions
from .mesh import SectionMesh, section_mesh
from .operators import SectionOperators
from .space import SectionSpace
from .thin import differences_across
from .timoshenko import SectionStiffness, stiffness
from .warping import WELL, WarpingSolver

NOISE = 2.2e-16  # relative change of coordinates that measures the round-off
TRIALS = 3  # differences that are looked at; the true error is one of a few such numbers
FAINT = 1e-7  # of K, scaled: less than any error of discretisation that an analysis is asked for
LARGEST_GROWTH = 1e14  # of a random load where solutions are corrected by their residual
KEPT = 8  # meshes (and degrees) that a process keeps


class SectionProblem:
    """The warping problem of a mesh at one degree of the field.

    Parameters
    ----------
    mesh : the cells
    degree : see `SectionSpace`
    """

    def __init__(
        self, mesh: SectionMesh, degree: int | None, team: fenicsx.Team = fenicsx.ALONE
    ) -> None:
        self.mesh = mesh
        self.space = SectionSpace(mesh.cells, degree)
        self.team = team
        self.degree = degree
        self._is_thin = False  # known after the first solution
        self._growth = 0.0  # of the last solution
        self._kept: dict[int, tuple[SectionOperators, WarpingSolver]] = {}

    @property
    def operators(self) -> SectionOperators:
        """Operators with the displacements of nodes as unknowns."""
        return self._prismatic(self.space)[0]

    @property
    def solver(self) -> WarpingSolver:
        """Solver with the displacements of nodes as unknowns."""
        return self._prismatic(self.space)[1]

    def _prismatic(self, space: SectionSpace) -> tuple[SectionOperators, WarpingSolver]:
        """Operators, and the solver that keeps the pattern and the symbolic factorisation."""
        if id(space) not in self._kept:
            tools = SectionOperators(space, self.team), WarpingSolver(space, team=self.team)
            self._kept[id(space)] = tools
        return self._kept[id(space)]

    @cached_property
    def _thin(self) -> SectionSpace | None:
        """The space with differences across thin walls and at their corners as unknowns."""
        unknowns = differences_across(self.space)
        return None if unknowns is None else self.space.expressed(unknowns)

    @cached_property
    def _thin_twisted(self) -> SectionSpace | None:
        """The same without corners."""
        unknowns = differences_across(self.space, corners=False)
        return None if unknowns is None else self.space.expressed(unknowns)

    def _thin_for(self, k: Array | None) -> SectionSpace | None:
        """The space for thin walls of a prismatic or a twisted beam, made when it is needed."""
        return self._thin if k is None else self._thin_twisted

    def solve(
        self,
        C: Array,
        *,
        k: Array | None = None,
        doubtful: bool = False,
        measured: bool = True,
        known: SectionStiffness | CentralSolutions | None = None,
    ) -> SectionStiffness | CentralSolutions:
        """The 6x6 stiffness for given stiffness at the points, (c, 1 or q, 6, 6) [Pa].

        `k` (3,) is the initial twist and curvature of the beam, None for a prismatic one.
        With `doubtful`, equations that appear to be singular are solved too. Without `measured`,
        round-off is not measured; for a `known` result of this problem it is measured only.

        If the condition of the equations requires it, they are solved with unknowns that suit thin
        walls, and their round-off is measured: the difference from solutions with coordinates
        that are changed in their last digit. One such difference can be small by chance: where it
        matters, the largest of three counts.
        """
        result = known or self._solve(C, k, doubtful)
        if self._growth <= WELL or not measured:
            return result
        rng, found = np.random.default_rng(0), np.zeros((6, 6))
        for _ in range(TRIALS):
            found = np.maximum(found, np.abs(self._disturbed(rng, C, k, doubtful).K - result.K))
            if scaled(found, result.K).max() < FAINT:
                break
        return replace(
            result,
            round_off=found,
            doubtful=self._growth > LARGEST_GROWTH,
        )

    def _disturbed(
        self, rng: np.random.Generator, C: Array, k: Array | None, doubtful: bool
    ) -> SectionStiffness | CentralSolutions:
        """The solution with coordinates that are changed in their last digit."""
        noise = 1.0 + NOISE * rng.choice([-1.0, 1.0], self.mesh.cells.points.shape)
        cells = replace(self.mesh.cells, points=self.mesh.cells.points * noise)
        other = SectionProblem(replace(self.mesh, cells=cells), self.degree, self.team)
        other._is_thin = self._is_thin
        return other._solve(C, k, doubtful)

    def end_compliance(self, result: SectionStiffness | CentralSolutions, C: Array) -> Array | None:
        """See `end_effects`; None of twisted and curved beams. `C` is that of `result`."""
        if isinstance(result, CentralSolutions):
            return None
        operators, solver = self._prismatic(result.space)
        solver.factorise(operators.E(C))  # another material may have been solved since
        return end_compliance(result, solver, C)

    def _solve(
        self, C: Array, k: Array | None, doubtful: bool
    ) -> SectionStiffness | CentralSolutions:
        """The stiffness, by the unknowns that the condition requires."""
        result = None
        if not self._is_thin:
            try:
                result = self._by(self.space, C, k, doubtful)
            except (fenicsx.FactorisationError, SectionError):
                if self._thin_for(k) is None:
                    raise
            else:
                if self._growth <= WELL or self._thin_for(k) is None:
                    return result
        thin = self._thin_for(k)
        assert thin is not None
        try:
            better = self._by(thin, C, k, doubtful)
        except fenicsx.FactorisationError:
            if result is None:
                raise
            return result
        self._is_thin, self._growth = True, max(self._growth, 2.0 * WELL)
        return better

    def _by(
        self, space: SectionSpace, C: Array, k: Array | None, doubtful: bool
    ) -> SectionStiffness | CentralSolutions:
        limit = np.inf if doubtful else LARGEST_GROWTH
        if k is not None:
            found = central_solutions(space, k, C, self.team, limit)
            self._growth = found.growth
            return found
        operators, solver = self._prismatic(space)
        solver.largest_growth = limit
        result = stiffness(space, solver, operators.E(C), C)
        self._growth = solver.growth
        return result


def section_problem(
    mesh_spec: Mapping[str, Any],
    where: str,
    degree: int | None,
    team: fenicsx.Team = fenicsx.ALONE,
) -> SectionProblem:
    """The problem on the mesh of a description.

    Raises SectionError if the degree of the field is below that of the geometry.
    """
    mesh = section_mesh(mesh_spec, where)
    if degree is not None and degree < mesh.cells.degree:
        raise SectionError(
            f"{where}.mesh.degree = {degree}: expected at least {mesh.cells.degree}, the degree of "
            "the mesh: a lower field cannot follow its curved edges"
        )
    return _kept(mesh, degree, team)


@lru_cache(maxsize=KEPT)
def _kept(mesh: SectionMesh, degree: int | None, team: fenicsx.Team) -> SectionProblem:
    return SectionProblem(mesh, degree, team)
