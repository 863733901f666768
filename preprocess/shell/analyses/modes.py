"""Natural modes and load factors of a shell, in the order of its mesh file, with their errors."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....solver.errors import coded
from ....solver.math.arrays import Array
from ....solver.package.shell.shell_schema import ShellBuckling, ShellCases, ShellModes
from ..model.freedom import Freedom
from ..model.shell_problem import ShellProblem, mode_count
from ..model.shell_warnings import Progress, Warnings, drilling_warning, zero_energy_warnings
from ..model.states import warped_warnings
from .buckling import Stressed, buckled, buckling, check_stable
from .cases import by_node
from .discretisation import (
    CHEAP,
    FinerMesh,
    at_points,
    energy_errors,
    frequency_errors,
    load_factor_errors,
)
from .frequencies import natural_modes

# Estimated error of a first load factor, a frequency or a strain energy that is warned about.
COARSE = 0.05
# A plate with an acute corner has an obtuse one, where moments are infinite (Williams 1952: where
# it is simply supported, above 90 deg).
SHARP = np.radians(75.0)
WARPED = {"shell-triangles-warped", "shell-quadrilaterals-warped"}


def shell_modes(
    stressed: Stressed, finer: FinerMesh, warnings: Warnings, begin: Progress
) -> tuple[ShellModes | None, str]:
    """The natural modes that the specification asks for, and why their errors are not estimated.

    None without [frequencies]; an empty reason if the errors are estimated.

    Parameters
    ----------
    stressed : the shell with the displacements of its load cases
    finer : the shell on a mesh of half the cell size
    warnings : appended to
    begin : called with one line at the beginning of each step

    Raises
    ------
    ShellError
        A wrong key, a shell that has buckled, no convergence.
    """
    problem = stressed.problem
    table = problem.spec.get("frequencies")
    if table is None:
        return None, ""
    count = mode_count(table, f"{problem.where}.frequencies")
    mesh, free = problem.mesh, table.get("free", False)
    freedom, rigid, drilling = free_or_held(problem, free)
    if drilling:
        warnings += drilling_warning(len(drilling))
    free_motions = as_columns(freedom, rigid, drilling)
    begin(f"{count} modes, {freedom.n_free} unknowns")
    case, where = table.get("prestress"), f"{problem.where}.frequencies.prestress"
    K = stressed.stiffness(case, where)
    if case is not None and not free_motions.size:
        check_stable(freedom.reduced(K), problem, case, where)
    found_modes = natural_modes(K, problem.M, freedom, count, free_motions, problem.team)
    warnings += zero_energy_warnings(found_modes.n_zero, len(rigid))
    elastic = range(found_modes.n_zero, found_modes.shapes.shape[1])
    locked = warped_warnings(
        problem, found_modes.shapes[:, elastic], [f"mode {i + 1}" for i in elastic]
    )
    warnings += locked
    values = np.where(
        np.arange(len(found_modes.values)) < found_modes.n_zero, 0.0, found_modes.values
    )
    if case is not None and (values < 0.0).any():
        raise buckled(case, where)
    error, left_out = None, _left_out(table, finer)
    if not left_out:
        error = frequency_errors(
            finer, case, np.sqrt(values), found_modes.shapes, found_modes.n_zero, free
        )
        if error is None:
            left_out = f"not possible on a mesh of half the cell size, {finer.unknowns} unknowns"
    # of cells that lock the other warning names the cause; a finer mesh of them is far off, too
    if error is not None and not locked:
        hertz = np.sqrt(values) / (2.0 * np.pi)
        names = [f"frequency {i - found_modes.n_zero + 1}, {f:.4g} Hz" for i, f in enumerate(hertz)]
        warnings += _coarse(names, error)
    modes = ShellModes(
        np.sqrt(values),
        by_node(mesh, found_modes.shapes),
        problem.resultants(found_modes.shapes),
        found_modes.n_zero,
        error,
    )
    return modes, left_out


def free_or_held(problem: ShellProblem, free: bool) -> tuple[Freedom, list[Array], list[Array]]:
    """Degrees of freedom of modes, with or without the supports, and their free motions."""
    freedom = problem.modes_freedom
    if free:
        freedom = Freedom(problem.mesh, problem.links, flat=problem.flat)
    return freedom, *problem.free_motions(freedom)


def as_columns(freedom: Freedom, rigid: list[Array], drilling: list[Array]) -> Array:
    """Free motions as columns, (n_dof, k).

    Parameters
    ----------
    freedom : degrees of freedom of the shell
    rigid, drilling : motions (n_dof,) of both kinds
    """
    return np.array([*rigid, *drilling]).reshape(-1, freedom.n_dof).T


def shell_buckling(
    stressed: Stressed, finer: FinerMesh, warnings: Warnings, begin: Progress
) -> ShellBuckling | None:
    """The load factors that the specification asks for; None without [buckling].

    Parameters
    ----------
    stressed, finer, warnings, begin : as of `shell_modes`

    Raises
    ------
    ShellError
        As `buckling`.
    """
    problem, names = stressed.problem, stressed.names
    table = problem.spec.get("buckling")
    if table is None:
        return None
    begin("buckling")
    factors = buckling(stressed, table, f"{problem.where}.buckling", warnings)
    errors = load_factor_errors(finer, table, factors) if table.get("error", False) else None
    for name, error in (errors or {}).items():
        if len(error):
            what = f"load case {name}: the load factor {factors[name].values[0]:.4g}"
            warnings += _coarse([what], error[:1])
    rows = [names.index(name) for name in factors]
    shapes = [by_node(problem.mesh, f.shapes) for f in factors.values()]
    return ShellBuckling(
        case=np.repeat(rows, [len(f.values) for f in factors.values()]).astype(np.int64),
        factors=np.concatenate([np.zeros(0), *(f.values for f in factors.values())]),
        shapes_G=np.concatenate([np.zeros((0, problem.mesh.n_node, 6)), *shapes]),
        reversed=np.array([factors[name].reversed if name in factors else 0.0 for name in names]),
        error=None if errors is None else np.concatenate([np.zeros(0), *errors.values()]),
    )


def case_errors(
    problem: ShellProblem, cases: ShellCases, finer: FinerMesh, asked: bool, warnings: Warnings
) -> Array | None:
    """Relative errors (l,) of the strain energies of load cases by the mesh, None if not estimated.

    A moment at a point has no limit for finer cells.

    Parameters
    ----------
    problem : the shell
    cases : results of its load cases
    finer : the shell on a mesh of half the cell size
    asked : estimate also where it is not cheap
    warnings : appended to
    """
    if not cases.names or not (asked or finer.cheap):
        return None
    error = energy_errors(finer, cases.energy, slow=has_sharp_corner(problem))
    codes = {warning["code"] for warning in warnings}
    if error is None or codes & WARPED:  # the other warning names the cause
        return error
    moments, forces = (at_points(problem, key) for key in ("moment", "force"))
    judged = np.where([name in moments for name in cases.names], 0.0, error)
    names, what = [f"load case {name}" for name in cases.names], ": the strain energy"
    at_point = cases.names[int(np.argmax(np.abs(judged)))] in forces
    more = ", and give forces at points a length or an area" if at_point else ""
    warnings += _coarse(names, judged, what, more)
    return error


def has_sharp_corner(problem: ShellProblem) -> bool:
    """Whether the edge of the shell has a corner with an acute angle inside."""
    mesh, angle = problem.mesh, np.zeros(problem.mesh.n_node)
    for region in problem.regions:
        x = mesh.points_G[region.nodes]
        a, b = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
        size = np.linalg.norm(a, axis=2) * np.linalg.norm(b, axis=2)
        own = np.arccos(np.clip((a * b).sum(axis=2) / size, -1.0, 1.0))
        np.add.at(angle, region.nodes, own)
    return bool((angle[mesh.edges.nodes[mesh.edges.count == 1]] < SHARP).any())


def _left_out(table: Mapping[str, Any], finer: FinerMesh) -> str:
    """Why the errors of frequencies are not estimated; empty if they are."""
    asked = table.get("error")
    if asked is False:
        return "error = false in [frequencies]"
    if asked is None and not finer.cheap:
        return (
            f"above {CHEAP} unknowns the estimate takes several times as long as the frequencies; "
            "ask for it by error = true in [frequencies]"
        )
    return ""


def _coarse(names: list[str], error: Array, what: str = "", more: str = "") -> Warnings:
    """Warning about the worst of some errors (m,), if it is large; `what` it is, `more` to do."""
    bad = np.count_nonzero(np.abs(error) > COARSE)
    if not bad:
        return []
    worst = int(np.argmax(np.abs(error)))
    others = "" if bad == 1 else f" (worst of {bad})"
    way = "high" if error[worst] > 0.0 else "low"
    return coded(
        "shell-mesh-coarse",
        f"{names[worst]}{others}{what} is about {100.0 * abs(error[worst]):.2g} % too {way} by its "
        f"mesh; use smaller cells: refine = 1 in [mesh]{more}",
    )
