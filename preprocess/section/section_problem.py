"""A section's mesh with all data that do not depend on material, and its solutions.

Meshes are kept for all lay-ups. A solution is that of a field of some degree, and of one degree
more, whose difference is the estimate.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...solver.math.arrays import Array
from ...solver.package.common.plain_data import canonical
from .. import fenicsx
from .estimate import (
    REGULAR,
    cell_exponents,
    error_energy,
    error_estimate,
    relative,
    singular_error,
)
from .helical import CentralSolutions, central_solutions
from .recovery import Result
from .section_specification import ALLOWED, IllConditioned, SectionError, curvature_of
from .space.layers import Layup, along_walls, layup
from .space.section_cells import turned
from .space.section_mesh import SectionMesh, section_mesh
from .space.space import SectionSpace
from .space.unknowns import differences_across
from .timoshenko import scaled, stiffness
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
        self._thin: dict[bool, SectionSpace | None] = {}
        self._is_thin = False  # known after the first solution
        self._growth = 0.0  # of the last solution
        self._solvers: dict[int, WarpingSolver] = {}

    def solver_of(self, space: SectionSpace) -> WarpingSolver:
        """The solver that keeps the pattern and the symbolic factorisation of some unknowns."""
        if id(space) not in self._solvers:
            self._solvers[id(space)] = WarpingSolver(space)
        return self._solvers[id(space)]

    def _thin_for(self, k: Array | None) -> SectionSpace | None:
        """The space with differences across thin walls as unknowns, made when it is needed.

        Those of a prismatic beam include differences at the corners of walls.
        """
        prismatic = k is None
        if prismatic not in self._thin:
            x = self.space.unknowns_at_nodes()[1]
            unknowns = differences_across(x, self.space.dofs, corners=prismatic)
            self._thin[prismatic] = None if unknowns is None else self.space.expressed(unknowns)
        return self._thin[prismatic]

    def solve(
        self,
        C: Array,
        *,
        k: Array | None = None,
        doubtful: bool = False,
        measured: bool = True,
        known: Result | None = None,
    ) -> Result:
        """The 6x6 stiffness for given stiffness at the points.

        If the condition of the equations requires it, they are solved with unknowns that suit thin
        walls, and their round-off is measured: the difference from solutions with coordinates
        that are changed in their last digit, and with cells that are numbered from another corner.
        The round-off of the functions in a cell is the same in all cells, so that it adds up:
        noise of the coordinates alone would not show it. One such difference can be small by
        chance: where it matters, the largest of three counts.

        Parameters
        ----------
        C : (c, 1 or q, 6, 6) stiffness at the points, section axes [Pa]
        k : (3,) initial twist and curvature of the beam [rad/m]; None: prismatic
        doubtful : solve equations that appear to be singular, too
        measured : measure the round-off
        known : result of this problem, of which only the round-off is measured
        """
        C = C[self.space.own]
        result = known or self._solve(C, k, doubtful)
        if self._growth <= WELL or not measured:
            return result
        rng, change = np.random.default_rng(0), np.zeros((6, 6))
        for _ in range(TRIALS):
            change = np.maximum(change, np.abs(self._disturbed(rng, C, k, doubtful).K - result.K))
            if scaled(change, result.K).max() < FAINT:
                break
        size = np.sqrt(np.diag(result.K))
        return replace(
            result,
            round_off=change + LAST_DIGITS * np.outer(size, size),
            doubtful=self._growth > LARGEST_GROWTH,
        )

    def _disturbed(
        self, rng: np.random.Generator, C: Array, k: Array | None, doubtful: bool
    ) -> Result:
        """The solution with other last digits of the coordinates and other first corners."""
        # with a stiffness at every point of integration, their order must not change
        cells = turned(self.mesh.cells) if C.shape[1] == 1 else self.mesh.cells
        noise = 1.0 + NOISE * rng.choice([-1.0, 1.0], cells.points.shape)
        cells = replace(cells, points=cells.points * noise)
        other = SectionProblem(replace(self.mesh, cells=cells), self.degree, self.team).like(self)
        return other._solve(C, k, doubtful)

    def like(self, coarser: "SectionProblem") -> "SectionProblem":
        """This problem, with the unknowns that a coarser one of the section needed.

        The condition grows with the degree and with the number of cells.
        """
        self._is_thin = self._is_thin or coarser._is_thin
        return self

    def factorised(self, result: Result, C: Array) -> WarpingSolver | None:
        """The solver of a result with its factors; None of twisted and curved beams."""
        if isinstance(result, CentralSolutions):
            return None
        solver = self.solver_of(result.space)
        solver.factorise(result.space.E(C[self.space.own]))  # another material may be in it
        return solver

    def _solve(self, C: Array, k: Array | None, doubtful: bool) -> Result:
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
    ) -> Result:
        """Solve with the unknowns of a space.

        Raises IllConditioned, before anything but the factorisation is done, unless the growth of
        a random load `is_enough`.
        """
        limit = np.inf if doubtful else LARGEST_GROWTH
        if k is not None:
            solutions = central_solutions(space, k, C, limit, is_enough)
            self._growth = solutions.equations.growth
            return solutions
        solver = self.solver_of(space)
        solver.largest_growth, solver.shift = limit, shift
        result = stiffness(space, solver, space.E(C), C, is_enough)
        self._growth = solver.growth
        return result


def section_problem(
    spec: Mapping[str, Any], where: str, degree: int | None, team: fenicsx.Team = fenicsx.ALONE
) -> SectionProblem:
    """The problem on the mesh of a description.

    Parameters
    ----------
    spec : tables `mesh` and `regions`
    where : file or section, for messages
    degree : of the warping; None: the functions of the nodes of the mesh
    team : processes that share the matrices; a mesh of few cells is solved by each

    Raises
    ------
    SectionError
        A degree of the field below that of the geometry.
    """
    mesh = section_mesh(spec["mesh"], where)
    if "file" in spec["mesh"] and mesh.cells.degree == 2:
        mesh = _along_walls(mesh, canonical(spec["regions"]), where)
    if degree is not None and degree < mesh.cells.degree:
        raise SectionError(
            f"{where}.mesh.degree = {degree}: expected at least {mesh.cells.degree}, the degree of "
            "the mesh: a lower field cannot follow its curved edges"
        )
    if mesh.cells.n_cell < team.size:
        team = fenicsx.ALONE
    return _kept(mesh, degree, team)


@lru_cache(maxsize=KEPT)
def _along_walls(mesh: SectionMesh, regions: str, where: str) -> SectionMesh:
    return along_walls(mesh, json.loads(regions), where)


@lru_cache(maxsize=KEPT)
def _kept(mesh: SectionMesh, degree: int | None, team: fenicsx.Team) -> SectionProblem:
    return SectionProblem(mesh, degree, team)


# A thin twisted wall bends without stretching, which low degrees cannot represent in long cells.
MOST_DEGREE = 6  # to which a twisted section is raised
LARGE = 20_000  # unknowns of a section that is raised to no more than 4
MOST_OF_LARGE = 4
RESOLVED = 0.01  # estimate, scaled, above which it is


@dataclass(frozen=True)
class Solved:
    """A section solved with a field of some degree, and with one degree more."""

    problem: SectionProblem
    lay: Layup
    result: Result
    richer: "Solved | None" = None
    error: Array | None = None  # estimate (6, 6) by the difference, in units of K
    indicator: Array | None = None  # (c,) of the error of each cell


def compared(solved: Solved, spec: Mapping[str, Any], where: str, *, first: bool) -> Solved:
    """With the solution of one degree more, and the estimate.

    Parameters
    ----------
    solved : the section by the lower degree
    spec : description of the section
    where : file or section, for messages
    first : its mesh is not refined yet; it is kept for other sections
    """
    coarse, degree = solved.problem, solved.problem.space.degree + 1
    if first:  # that of a mesh without refinement is kept for others
        problem = section_problem(spec, where, degree, coarse.team).like(coarse)
    else:
        problem = SectionProblem(coarse.mesh, degree, coarse.team).like(coarse)
    lay = layup(spec, problem.mesh, problem.space, where)
    richer = Solved(problem, lay, solve(problem, lay, where, spec, measured=False))
    degree, K, better = coarse.space.degree, solved.result.K, richer.result
    energy = error_energy(solved.result, better, lay.stiffness)
    indicator = relative(energy, better.K)
    cells = problem.mesh.cells
    exponents = cell_exponents(cells, solved.lay.stiffness, indicator, REGULAR)
    error = error_estimate(K, better.K, degree) + singular_error(K, energy, exponents, degree)
    return replace(solved, richer=richer, error=error, indicator=indicator)


def resolved(solved: Solved, spec: Mapping[str, Any], where: str) -> Solved:
    """With as many degrees more as a twisted section requires; its round-off is measured.

    Parameters
    ----------
    solved : the section, with its estimate
    spec : description of the section
    where : file or section, for messages
    """
    before = None
    while solved.error is not None and solved.problem.space.degree < MOST_DEGREE:
        if scaled(solved.error, solved.result.K).max() <= RESOLVED:
            break
        richer = solved.richer
        assert richer is not None
        space = richer.problem.space
        if space.degree > MOST_OF_LARGE and space.n_dof > LARGE:
            break
        try:
            before, solved = solved, compared(richer, spec, where, first=False)
        except SectionError:  # round-off of the higher degree
            break
    try:
        return _measured(solved, spec, where)
    except SectionError:  # the same
        if before is None:
            raise
        return _measured(before, spec, where)


def _measured(solved: Solved, spec: Mapping[str, Any], where: str) -> Solved:
    """With the round-off of its result."""
    result = solve(solved.problem, solved.lay, where, spec, known=solved.result)
    return replace(solved, result=result)


def solve(
    problem: SectionProblem,
    lay: Layup,
    where: str,
    spec: Mapping[str, Any],
    *,
    measured: bool = True,
    known: Result | None = None,
) -> Result:
    """Solve a problem; errors name the section.

    Parameters
    ----------
    problem : of the section's mesh
    lay : plies and stiffness at its points
    where : file or section, for messages
    spec : description of the section: its curvature, and what it allows
    measured, known : as of `SectionProblem.solve`

    Raises
    ------
    SectionError
        Singular or ill-conditioned equations, unless the description allows them.
    """
    doubtful = ALLOWED[1] in spec.get("allow", ())
    try:
        k = curvature_of(spec)
        return problem.solve(lay.stiffness, k=k, doubtful=doubtful, measured=measured, known=known)
    except fenicsx.FactorisationError as error:
        hint = ""
        if isinstance(error, fenicsx.SingularError):
            hint = f'; allow = ["{ALLOWED[1]}"] solves it anyway'
        raise SectionError(f"{where}: {error}{hint}") from error
    except SectionError as error:
        raise SectionError(f"{where}: {error}") from error
