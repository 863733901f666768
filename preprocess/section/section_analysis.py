"""Analysis of a cross-section: stiffness, mass and stress recovery from its description."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...solver.errors import coded
from ...solver.math.arrays import Array
from ...solver.package.common.design import Derivative
from ...solver.package.common.plausible import described_doubts, not_allowed, section_doubts
from ...solver.package.section.section_schema import SectionFile
from .. import fenicsx
from .derivatives import derivatives
from .estimate import error_of_edges, worst_cells
from .helical import CentralSolutions, TwistedStrains
from .recovery import (
    end_compliance,
    mesh_data,
    nodal_displacements,
    section_recovery,
    unit_strains,
    unit_warping,
)
from .section_parameters import Targets, by_size, moves, parameters, rates
from .section_problem import (
    LAST_DIGITS,
    SectionProblem,
    Solved,
    compared,
    resolved,
    section_problem,
    solve,
)
from .section_specification import SectionError, check_spec, curvature_of, degree_of
from .section_verification import verified
from .section_warnings import (
    REVERSAL,
    coarse_warnings,
    described_warnings,
    finer_mesh,
    result_warnings,
    reversal_warnings,
    taper_error,
)
from .space.layers import layup
from .space.section_cells import refined
from .space.section_mesh import SectionMesh
from .timoshenko import (
    SectionStiffness,
    mass_centre,
    mass_matrix,
    scaled,
    shear_centre,
    tension_centre,
)

MOST_STEPS = 25  # of refinement
MOST_DOFS = 400_000  # limit of refinement: a larger problem takes minutes and gigabytes

Progress = Callable[[str], None]


def analyse(
    spec: Mapping[str, Any],
    where: str | None = None,
    *,
    estimate: bool = True,
    accuracy: float | None = None,
    recovery_degree: int | None = None,
    verify: bool = False,
    design: Mapping[str, Targets] | None = None,
    design_strains: bool = True,
    discretisation: Mapping[str, Any] | None = None,
    problem: SectionProblem | None = None,
    team: fenicsx.Team = fenicsx.ALONE,
    progress: Progress | None = None,
) -> SectionFile:
    """Stiffness, mass, error estimate and recovery of a cross-section.

    Parameters
    ----------
    spec : plain data, see docs/section-description.md for the meaning and
        solver/inputs/section/specification.py for the form: name, convention, mesh, materials,
        regions
    where : file and key of the description for messages, the section's name by default
    estimate : also solve with one degree more to estimate the error of K
    accuracy : refine the mesh until the estimate, scaled by sqrt(K_ii K_jj), is below this
    recovery_degree : recover stresses at the points of a coarser rule (3: four in a quadrilateral)
        instead of all integration points
    verify : compute K by a second method as well (section_verification.py)
    design : parameters by whose change everything is differentiated, see `parameters`; with
        `recovery_degree` but for warping and mesh
    design_strains : whether derivatives are also those of strains, see `derivatives`
    discretisation : of a section with other values of parameters, from its provenance: the same
        divisions of cells and degree, whatever the estimate says. The derivatives are those of
        such analyses
    problem : on another mesh than that of the specification
    team : processes that all call this with the same arguments and share the matrices, unless
        derivatives are asked for; each gets the whole result
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
    asked = parameters(spec, design or {}, where)
    if asked:
        team = fenicsx.ALONE  # each process solves the whole section
    divided: list[NDArray[np.bool_]] = []
    if problem is None and discretisation is not None:
        accuracy = None
        problem, divided = _as_before(spec, where, discretisation, team)
    elif problem is None:
        problem = section_problem(spec, where, degree_of(spec), team)
    compare = estimate or accuracy is not None
    # of a twisted section, the round-off is measured at the degree that it is raised to
    raised = compare and curvature_of(spec) is not None and "degree" not in spec["mesh"]
    raised = raised and discretisation is None
    edges = None
    steps: list[dict[str, float | None]] = []
    while True:
        begin(f"mesh, refined {len(steps)} times" if steps else "mesh")
        step = _on_mesh(
            problem, spec, where, edges, begin, accuracy, compare=compare, raised=raised
        )
        del problem
        edges, worst, unknowns = step.edges, step.worst, step.solved.problem.space.n_dof
        lap = time.perf_counter() - start
        steps.append({"refine": len(steps), "dofs": unknowns, "error": worst, "seconds": lap})
        if accuracy is None or worst is None or worst <= accuracy or step.reversal > accuracy:
            break
        if edges > accuracy:
            step.warnings += coded(
                "accuracy-not-met",
                f"estimated error {worst:.1e}, {accuracy:.1e} requested; curved "
                f"edges of the mesh are parabolas, which alone costs {edges:.1e}: use "
                f"{finer_mesh(spec['mesh'])}",
            )
            break
        coarser, indicator = step.solved.problem, step.solved.indicator
        assert indicator is not None
        divided.append(worst_cells(indicator))
        cells = refined(coarser.mesh.cells, divided[-1])
        cost = unknowns * cells.n_cell / coarser.mesh.cells.n_cell
        if cost > MOST_DOFS or len(steps) > MOST_STEPS:
            step.warnings += coded(
                "accuracy-not-met",
                f"estimated error {worst:.1e} with {unknowns} dofs, "
                f"{accuracy:.1e} requested; the next refinement would have {cost:.0f}",
            )
            break
        del step  # its memory serves the next one
        mesh = replace(coarser.mesh, cells=cells)
        problem = SectionProblem(mesh, coarser.space.degree, team).like(coarser)
        del coarser
    problem, lay, result = step.solved.problem, step.solved.lay, step.solved.result
    warnings, second = step.warnings, None
    if verify:
        begin("verification")
        own, k = degree_of(spec) is None, curvature_of(spec)
        second = verified(result.space, lay.stiffness, result.K, k=k, own=own)
        warnings += second.warnings
    warnings += coarse_warnings(step.solved.error, result.K, spec["mesh"])
    begin("recovery")
    density = lay.density
    if isinstance(result, CentralSolutions):
        density = density * TwistedStrains(problem.space, result.strains.k).all_g
    M = mass_matrix(problem.space, density)
    points, lay_points = result.space, lay
    if recovery_degree is not None:
        points = result.space.with_rule(recovery_degree)
        lay_points = layup(spec, problem.mesh, points, where)
    if degree_of(spec) is not None:  # a file of another code may have other units
        diagonal = float(np.linalg.norm(np.ptp(problem.mesh.cells.points, axis=0)))
        doubts = [*described_doubts(spec), *section_doubts(diagonal, float(M[0, 0]))]
        warnings += [doubt.warning for doubt in not_allowed(spec, doubts)]
    strain = unit_strains(points, result)
    factorised = problem.factorised(result, lay.stiffness)
    of_ends = None
    if isinstance(result, SectionStiffness) and factorised is not None:
        of_ends = end_compliance(result, factorised, lay.stiffness[problem.space.own])
    section = SectionFile(
        name=str(spec.get("name", "section")),
        K=result.K,
        M=M,
        error_estimate=step.error,
        shear_centre=shear_centre(result.K),
        tension_centre=tension_centre(result.K),
        mass_centre=mass_centre(M),
        initial_curvature=curvature_of(spec),
        end_compliance=of_ends,
        mesh=mesh_data(problem.mesh, problem.space, lay),
        warping=nodal_displacements(result.space, unit_warping(result.space, result)),
        recovery=section_recovery(
            points, lay_points, points.team.stacked(strain), dict(spec["materials"])
        ),
        warnings=tuple(warnings),
        provenance={
            "spec": dict(spec),
            "dofs": problem.space.n_dof,
            "degree": problem.space.degree,
            "refinements": steps,
            "discretisation": {
                "degree": problem.degree,
                "divided": [np.flatnonzero(marked).tolist() for marked in divided],
            },
            "verification": None if second is None else second.words,
            "round_off": _worst(result.round_off, result.K),
            "ranks": problem.team.size,
            "seconds": time.perf_counter() - start,
            "versions": fenicsx.versions(),
        },
    )
    if not asked:
        return section
    begin("derivatives")
    shown, by_name = recovery_degree is None, dict[str, dict[str, Array]]()
    if fixed := [rates(parameter, lay) for parameter in asked if not moves(parameter)]:
        at = points, lay_points, strain
        by_name = derivatives(result, factorised, fixed, *at, shown=shown, strains=design_strains)

    def analysed(other: Mapping[str, Any], mesh: SectionMesh) -> SectionFile:
        moved = SectionProblem(mesh, problem.degree).like(problem)
        return analyse(other, where, estimate=False, recovery_degree=recovery_degree, problem=moved)

    for parameter in filter(moves, asked):
        if any(warning["code"] == "plies-not-resolved" for warning in lay.warnings):
            text = "cells contain more than one ply: let mesh lines follow the plies"
            raise parameter.refused(text)
        of_size = by_size(parameter, problem.mesh, divided, analysed)
        left_out = () if shown else ("mesh/", "warping")
        by_name[parameter.name] = {
            path: rate for path, rate in of_size.items() if not path.startswith(left_out)
        }
    of_design = tuple(
        Derivative(p.name, p.kind, tuple(t.table for t in p.targets), by_name[p.name])
        for p in asked
    )
    return replace(section, design=of_design)


@dataclass
class _Step:
    """A section solved on one mesh."""

    solved: Solved
    edges: float  # error of K by edges that are parabolas, over its diagonal
    error: Array | None  # estimate (6, 6) of all causes, in units of K
    reversal: float  # its part by fibres that reverse, over the diagonal of K
    warnings: list[dict[str, str]]

    @property
    def worst(self) -> float | None:
        """Largest estimated error, over the diagonal of K."""
        return _worst(self.error, self.solved.result.K)


def _worst(error: Array | None, K: Array) -> float | None:
    return None if error is None else float(scaled(error, K).max())


def _on_mesh(
    problem: SectionProblem,
    spec: Mapping[str, Any],
    where: str,
    edges: float | None,
    begin: Progress,
    accuracy: float | None,
    *,
    compare: bool,
    raised: bool,
) -> _Step:
    """Solve a section on one mesh and estimate the error of K from all causes.

    Parameters
    ----------
    edges : error of K by the curved edges of the first mesh; None while that mesh is solved
    accuracy : requested accuracy of K
    compare : solve with one degree more, too
    raised : raise the degree where the estimate needs it
    """
    lay = layup(spec, problem.mesh, problem.space, where)
    first = edges is None
    if edges is None:
        edges = 0.0
        if degree_of(spec) is not None:
            # cells of another code are the section itself; others keep their edges when refined
            modulus = np.asarray(1.0 / np.linalg.inv(lay.stiffness[:, 0])[:, 0, 0], float)
            edges = error_of_edges(problem.mesh.cells, modulus)
    warnings = [*problem.mesh.warnings, *lay.warnings]
    warnings += described_warnings(spec, problem.space, lay, where)
    begin(f"warping, {problem.space.n_dof} dofs")
    solved = Solved(problem, lay, solve(problem, lay, where, spec, measured=not raised))
    if compare:
        begin("error estimate")
        solved = compared(solved, spec, where, first=first)
        if raised:
            solved = resolved(solved, spec, where)
    problem, lay, result, error = solved.problem, solved.lay, solved.result, solved.error
    warnings += result_warnings(result)
    size, reversal = np.sqrt(np.diag(result.K)), 0.0
    size = np.outer(size, size)
    if error is not None:
        # of opposite sign: a coarse field is too stiff, a parabola inside its arc too soft
        error = np.hypot(error, edges * size)
        if lay.reversing.any():
            # refinement moves the place of the reversal only slowly
            turned = solve(problem, lay.reversed_there(), where, spec, measured=False)
            other = np.abs(turned.K - result.K)
            error, reversal = error + other, float(scaled(other, result.K).max())
            limit = REVERSAL if accuracy is None else accuracy
            warnings += reversal_warnings(lay, problem.mesh.cells, reversal, limit)
    neglected, taper_warnings = taper_error(spec, problem.mesh.cells.points, result.K)
    warnings += taper_warnings
    if error is not None:
        # the rounding of sums over the unknowns, also where two solutions agree by chance
        error = error + LAST_DIGITS * np.sqrt(problem.space.n_dof) * size
        error = error if neglected is None else error + neglected
    if result.round_off is not None:
        error = result.round_off if error is None else error + result.round_off
    return _Step(solved, edges, error, reversal, warnings)


def _as_before(
    spec: Mapping[str, Any], where: str, discretisation: Mapping[str, Any], team: fenicsx.Team
) -> tuple[SectionProblem, list[NDArray[np.bool_]]]:
    """The problem with a known degree and known divisions, and these."""
    degree = discretisation["degree"]
    problem = section_problem(spec, where, degree, team)
    cells, divided = problem.mesh.cells, []
    for rows in discretisation["divided"]:
        if rows and not 0 <= min(rows) <= max(rows) < cells.n_cell:
            raise SectionError(f"{where}: discretisation: its cells are those of another mesh")
        divided.append(np.isin(np.arange(cells.n_cell), rows))
        cells = refined(cells, divided[-1])
    if divided:
        problem = SectionProblem(replace(problem.mesh, cells=cells), degree, team)
    return problem, divided
