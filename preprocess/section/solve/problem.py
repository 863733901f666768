"""A section's mesh with all data that do not depend on material, kept for all lay-ups."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ....solver.math.arrays import Array
from ... import fenicsx
from ..errors import IllConditioned, SectionError
from ..mesh.cells import turned
from ..mesh.mesh import SectionMesh, section_mesh
from ..space.operators import SectionOperators
from ..space.space import SectionSpace
from ..space.thin import differences_across
from .end_effects import end_compliance
from .estimate import scaled
from .helical import CentralSolutions, central_solutions
from .timoshenko import SectionStiffness, stiffness
from .warping import SHIFTS, WELL, WarpingSolver

NOISE = 2.2e-16  # relative change of coordinates that measures the round-off
TRIALS = 3  # differences that are looked at; the true error is one of a few such numbers
FAINT = 1e-7  # of K, scaled: less than any error of discretisation that an analysis is asked for
LAST_DIGITS = 16 * 2.2e-16  # of K, also where two solutions agree by chance
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
        self.space = SectionSpace(mesh.cells, degree, team=team)
        self.team = team
        self.degree = degree
        self._is_thin = False  # known after the first solution
        self._by_waves_for: Array | None = None  # curvature that needs the second solver
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
            tools = SectionOperators(space), WarpingSolver(space)
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
        that are changed in their last digit, and with cells that are numbered from another corner.
        The round-off of the functions in a cell is the same in all cells, so that it adds up:
        noise of the coordinates alone would not show it. One such difference can be small by
        chance: where it matters, the largest of three counts.
        """
        C = C[self.space.own]
        result = known or self._solve(C, k, doubtful)
        if self._growth <= WELL or not measured:
            return result
        rng, found = np.random.default_rng(0), np.zeros((6, 6))
        for _ in range(TRIALS):
            found = np.maximum(found, np.abs(self._disturbed(rng, C, k, doubtful).K - result.K))
            if scaled(found, result.K).max() < FAINT:
                break
        size = np.sqrt(np.diag(result.K))
        return replace(
            result,
            round_off=found + LAST_DIGITS * np.outer(size, size),
            doubtful=self._growth > LARGEST_GROWTH,
        )

    def _disturbed(
        self, rng: np.random.Generator, C: Array, k: Array | None, doubtful: bool
    ) -> SectionStiffness | CentralSolutions:
        """The solution with other last digits of the coordinates and other first corners."""
        # with a stiffness at every point of integration, their order must not change
        cells = turned(self.mesh.cells) if C.shape[1] == 1 else self.mesh.cells
        noise = 1.0 + NOISE * rng.choice([-1.0, 1.0], cells.points.shape)
        cells = replace(cells, points=cells.points * noise)
        other = SectionProblem(replace(self.mesh, cells=cells), self.degree, self.team).like(self)
        return other._solve(C, k, doubtful)

    def like(self, coarser: "SectionProblem") -> "SectionProblem":
        """This problem, with the unknowns and the solver that a coarser one of the section needed.

        The condition grows with the degree and with the number of cells.
        """
        self._is_thin = self._is_thin or coarser._is_thin
        self._by_waves_for = coarser._by_waves_for
        return self

    def end_compliance(self, result: SectionStiffness | CentralSolutions, C: Array) -> Array | None:
        """See `end_effects`; None of twisted and curved beams. `C` is that of `result`."""
        if isinstance(result, CentralSolutions):
            return None
        operators, solver = self._prismatic(result.space)
        C = C[self.space.own]
        solver.factorise(operators.E(C))  # another material may have been solved since
        return end_compliance(result, solver, C)

    def _solve(
        self, C: Array, k: Array | None, doubtful: bool
    ) -> SectionStiffness | CentralSolutions:
        """The stiffness, by the unknowns that the condition requires."""

        def is_enough(growth: float) -> bool:
            return growth <= WELL or self._thin_for(k) is None

        solvable = False
        if not self._is_thin:
            try:
                return self._by(self.space, C, k, doubtful, is_enough)
            except IllConditioned:
                solvable = True
            except (fenicsx.FactorisationError, SectionError):
                if self._thin_for(k) is None:
                    raise
        thin = self._thin_for(k)
        assert thin is not None
        try:
            better = self._by(thin, C, k, doubtful)
        except fenicsx.FactorisationError:
            if solvable:
                return self._by(self.space, C, k, doubtful)
            if k is not None:
                raise
            better = self._shifted(thin, C, doubtful)
        self._is_thin, self._growth = True, max(self._growth, 2.0 * WELL)
        return better

    def _shifted(self, space: SectionSpace, C: Array, doubtful: bool) -> Any:
        """The stiffness by conjugate gradients, with the smallest shift that can be factorised."""
        for shift in SHIFTS[:-1]:
            try:
                return self._by(space, C, None, doubtful, shift=shift)
            except fenicsx.FactorisationError:
                continue
        return self._by(space, C, None, doubtful, shift=SHIFTS[-1])

    def _by(
        self,
        space: SectionSpace,
        C: Array,
        k: Array | None,
        doubtful: bool,
        is_enough: Callable[[float], bool] | None = None,
        shift: float = 0.0,
    ) -> SectionStiffness | CentralSolutions:
        """Solve with the unknowns of a space.

        Raises IllConditioned, before anything but the factorisation is done, unless the growth of
        a random load `is_enough`.
        """
        limit = np.inf if doubtful else LARGEST_GROWTH
        if k is not None:
            known = self._by_waves_for is not None and np.array_equal(k, self._by_waves_for)
            found = central_solutions(space, k, C, limit, is_enough, by_waves=known)
            self._by_waves_for = k if found.by_waves else None
            self._growth = found.growth
            return found
        operators, solver = self._prismatic(space)
        solver.largest_growth, solver.shift = limit, shift
        result = stiffness(space, solver, operators.E(C), C, is_enough)
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
    if mesh.cells.n_cell < team.size:
        team = fenicsx.ALONE
    return _kept(mesh, degree, team)


@lru_cache(maxsize=KEPT)
def _kept(mesh: SectionMesh, degree: int | None, team: fenicsx.Team) -> SectionProblem:
    return SectionProblem(mesh, degree, team)
