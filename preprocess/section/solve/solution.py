"""Solutions of a section with a field of some degree and with one more, and their difference."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ....solver.math.arrays import Array
from ... import fenicsx
from ..errors import SectionError
from ..mesh.mesh import OF_MESH
from ..space.layers import Layup, layup
from .adaptive import Result, error_energy, relative
from .estimate import REGULAR, error_estimate, scaled, singular_error
from .guards import ALLOWED, curvature_of
from .problem import SectionProblem, section_problem
from .singular import cell_exponents

DEGREE = 2  # of the warping field
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
    """With the solution of one degree more, and the estimate."""
    problem = _richer(solved.problem, spec, where, first=first)
    lay = layup(spec, problem.mesh, problem.space, where)
    richer = Solved(problem, lay, solve(problem, lay, where, spec, measured=False))
    degree, K, better = solved.problem.space.degree, solved.result.K, richer.result
    energy = error_energy(solved.problem, solved.result, problem, better, lay.stiffness)
    indicator = relative(energy, better.K)
    cells = problem.mesh.cells
    exponents = cell_exponents(cells, solved.lay.stiffness, indicator, REGULAR)
    error = error_estimate(K, better.K, degree) + singular_error(K, energy, exponents, degree)
    return replace(solved, richer=richer, error=error, indicator=indicator)


def resolved(solved: Solved, spec: Mapping[str, Any], where: str) -> Solved:
    """With as many degrees more as a twisted section requires; its round-off is measured."""
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
        return measured(solved, spec, where)
    except SectionError:  # the same
        if before is None:
            raise
        return measured(before, spec, where)


def measured(solved: Solved, spec: Mapping[str, Any], where: str) -> Solved:
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
    """Solve a problem; a `known` result is only measured. Errors name the section."""
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


def degree_of(spec: Mapping[str, Any]) -> int | None:
    """Degree of the warping; None: the functions of the nodes of the mesh."""
    degree = spec["mesh"].get("degree", DEGREE)
    return None if degree == OF_MESH else int(degree)


def _richer(
    problem: SectionProblem, spec: Mapping[str, Any], where: str, *, first: bool
) -> SectionProblem:
    """The problem with one degree more; that of a mesh without refinement is kept for others."""
    degree = problem.space.degree + 1
    if first:
        return section_problem(spec["mesh"], where, degree, problem.team).like(problem)
    return SectionProblem(problem.mesh, degree, problem.team).like(problem)
