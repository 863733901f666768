"""Analysis of a cross-section: stiffness, mass and stress recovery from its description."""

import time
from collections.abc import Callable, Mapping
from typing import Any

from ...solver.math.arrays import Array
from ...solver.package.section.schema import SectionFile
from .. import fenicsx
from .errors import SectionError
from .estimate import error_estimate, scaled
from .guards import ALLOWED, check_degree, condition_warnings, solvability_warnings
from .helical import CentralSolutions
from .inertia import mass_centre, mass_matrix
from .layers import Layup, layup
from .mesh_data import mesh_data, nodal_displacements
from .problem import SectionProblem, section_problem
from .recovery import section_recovery, unit_strains, unit_warping
from .shape_along import curvature_of, curvature_warnings, taper_error
from .space import SectionSpace
from .spec import check_spec
from .timoshenko import SectionStiffness, shear_centre, tension_centre
from .twist import TwistedStrains

DEGREE = 2  # of the warping field
MOST_DOFS = 400_000  # limit of refinement: a larger problem takes minutes and gigabytes

Progress = Callable[[str], None]


def analyse(
    spec: Mapping[str, Any],
    where: str | None = None,
    *,
    estimate: bool = True,
    accuracy: float | None = None,
    recovery_degree: int | None = None,
    team: fenicsx.Team = fenicsx.ALONE,
    progress: Progress | None = None,
) -> SectionFile:
    """Stiffness, mass, error estimate and recovery of a cross-section.

    Parameters
    ----------
    spec : plain data, see docs/section-description.md for the meaning and
        solver/inputs/section/expand.py for the form: name, convention, mesh, materials, regions
    where : file and key of the description for messages, the section's name by default
    estimate : also solve with one degree more to estimate the error of K
    accuracy : refine the mesh until the estimate, scaled by sqrt(K_ii K_jj), is below this
    recovery_degree : recover stresses at the points of a coarser rule (3: four in a quadrilateral)
        instead of all integration points
    team : processes that all call this with the same arguments and share the work; each gets
        the whole result
        progress : called with one line at the beginning of each step

    Raises
    ------
    SectionError, MaterialError : a wrong description (file or section, key, value, expectation).
    MeshError : no mesh from gmsh.
    """
    start = time.perf_counter()
    where = where or f"section {spec.get('name', '')}".strip()
    check_spec(spec, where)
    begin = progress or (lambda _line: None)
    degree = int(spec["mesh"].get("degree", DEGREE))
    allow = tuple(spec.get("allow", ()))
    steps: list[dict[str, float | None]] = []
    refine = 0
    while True:
        begin(f"mesh, refined {refine} times" if refine else "mesh")
        problem = section_problem(spec["mesh"], where, degree, refine, team)
        lay = layup(spec, problem.mesh, problem.space, where)
        warnings = [
            *problem.mesh.warnings,
            *lay.warnings,
            *check_degree(problem.space, lay, where, allow),
        ]
        begin(f"warping, {problem.space.n_dof} dofs")
        result = _solve(problem, lay, where, spec)
        warnings += [*solvability_warnings(result), *condition_warnings(result)]
        warnings += curvature_warnings(result)
        error = None
        if estimate or accuracy is not None:
            begin("error estimate")
            error = _estimate(spec, where, problem, refine, result.K)
        neglected, found = taper_error(spec, problem.mesh.cells.points, result.K)
        warnings += found
        if error is not None and neglected is not None:
            error = error + neglected
        if result.round_off is not None:
            error = result.round_off if error is None else error + result.round_off
        lap = time.perf_counter() - start
        worst = None if error is None else float(scaled(error, result.K).max())
        steps.append(
            {"refine": refine, "dofs": problem.space.n_dof, "error": worst, "seconds": lap}
        )
        if accuracy is None or worst is None or worst <= accuracy:
            break
        if 4 * problem.space.n_dof > MOST_DOFS:
            warnings.append(
                {
                    "code": "accuracy-not-met",
                    "message": f"estimated error {worst:.1e} with {problem.space.n_dof} dofs, "
                    f"{accuracy:.1e} requested; the next refinement would have four times as many",
                }
            )
            break
        refine += 1
    begin("recovery")
    density = lay.density
    if isinstance(result, CentralSolutions):
        density = density * TwistedStrains(problem.space, result.strains.k).g
    M = mass_matrix(problem.space, density)
    points, lay_points = result.space, lay
    if recovery_degree is not None:
        points = SectionSpace(problem.mesh.cells, degree, recovery_degree)
        if result.space.over is not None:
            points = points.expressed(result.space.over)
        lay_points = layup(spec, problem.mesh, points, where)
    seconds = time.perf_counter() - start
    return SectionFile(
        name=str(spec.get("name", "section")),
        K=result.K,
        M=M,
        error_estimate=error,
        shear_centre=shear_centre(result.K),
        tension_centre=tension_centre(result.K),
        mass_centre=mass_centre(M),
        initial_curvature=curvature_of(spec),
        mesh=mesh_data(problem.mesh, problem.space, lay),
        warping=nodal_displacements(result.space, unit_warping(result.space, result)),
        recovery=section_recovery(
            points, lay_points, unit_strains(points, result), dict(spec["materials"])
        ),
        warnings=tuple(warnings),
        provenance={
            "spec": dict(spec),
            "dofs": problem.space.n_dof,
            "degree": degree,
            "refinements": steps,
            "round_off": None
            if result.round_off is None
            else float(scaled(result.round_off, result.K).max()),
            "seconds": seconds,
            "versions": fenicsx.versions(),
        },
    )


def _solve(
    problem: SectionProblem, lay: Layup, where: str, spec: Mapping[str, Any]
) -> SectionStiffness | CentralSolutions:
    doubtful = ALLOWED[1] in spec.get("allow", ())
    try:
        return problem.solve(lay.stiffness, k=curvature_of(spec), doubtful=doubtful)
    except fenicsx.FactorisationError as error:
        hint = ""
        if isinstance(error, fenicsx.SingularError):
            hint = f'; allow = ["{ALLOWED[1]}"] solves it all the same'
        raise SectionError(f"{where}: {error}{hint}") from error
    except SectionError as error:
        raise SectionError(f"{where}: {error}") from error


def _estimate(
    spec: Mapping[str, Any], where: str, problem: SectionProblem, refine: int, K: Array
) -> Array:
    degree = problem.space.degree + 1
    richer = section_problem(spec["mesh"], where, degree, refine, problem.team)
    lay = layup(spec, richer.mesh, richer.space, where)
    return error_estimate(K, _solve(richer, lay, where, spec).K, problem.space.degree)
