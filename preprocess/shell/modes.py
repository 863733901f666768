"""Natural modes and load factors of a shell, in the order of its mesh file, with their errors."""

from collections.abc import Callable

import numpy as np

from ...solver.math.arrays import Array
from ...solver.package.shell.schema import ShellBuckling, ShellModes
from .discretisation import FinerMesh, frequency_errors, load_factor_errors
from .freedom import Freedom
from .frequencies import natural_modes
from .guards import drilling_warning, zero_energy_warnings
from .mesh import ShellMesh
from .prestress import Stressed, buckled, buckling, check_stable
from .problem import ShellProblem
from .spec import mode_count
from .warped import warped_warnings

Progress = Callable[[str], None]
Warnings = list[dict[str, str]]

COARSE = 0.05  # estimated error of a first load factor or frequency that is warned about


def shell_modes(
    stressed: Stressed, finer: FinerMesh, warnings: Warnings, begin: Progress
) -> ShellModes | None:
    """The natural modes that the specification asks for; None without [frequencies]."""
    problem = stressed.problem
    table = problem.spec.get("frequencies")
    if table is None:
        return None
    count = mode_count(table, f"{problem.where}.frequencies")
    mesh, freedom = problem.mesh, problem.modes_freedom
    if table.get("free", False):
        freedom = Freedom(mesh, problem.links, flat=problem.flat)
    rigid, drilling = problem.free_motions(freedom)
    if drilling:
        warnings.append(drilling_warning(len(drilling)))
    free_motions = np.array([*rigid, *drilling]).reshape(-1, freedom.n_dof).T
    begin(f"{count} modes, {freedom.n_free} unknowns")
    case, where = table.get("prestress"), f"{problem.where}.frequencies.prestress"
    K = stressed.stiffness(case, where)
    if case is not None and not free_motions.size:
        check_stable(freedom.reduced(K), problem, case, where)
    found = natural_modes(K, problem.M, freedom, count, free_motions, problem.team)
    warnings += zero_energy_warnings(found.n_zero, len(rigid))
    warnings += _locked(problem, found.shapes[:, found.n_zero :], found.n_zero)
    values = np.where(np.arange(len(found.values)) < found.n_zero, 0.0, found.values)
    if case is not None and (values < 0.0).any():
        raise buckled(case, where)
    error = None
    if table.get("error", False) and not free_motions.size:
        error = frequency_errors(finer, case, np.sqrt(values), found.shapes)
    if error is not None and abs(error[0]) > COARSE:
        warnings.append(_coarse("the first frequency", float(error[0])))
    return ShellModes(
        np.sqrt(values),
        by_node(mesh, found.shapes),
        problem.resultants(found.shapes),
        found.n_zero,
        error,
    )


def shell_buckling(
    stressed: Stressed, finer: FinerMesh, warnings: Warnings, begin: Progress
) -> ShellBuckling | None:
    """The load factors that the specification asks for; None without [buckling]."""
    problem, names = stressed.problem, stressed.names
    table = problem.spec.get("buckling")
    if table is None:
        return None
    begin("buckling")
    found = buckling(stressed, table, f"{problem.where}.buckling", warnings)
    errors = load_factor_errors(finer, table, found) if table.get("error", False) else None
    for name, error in (errors or {}).items():
        if len(error) and abs(error[0]) > COARSE:
            what = f"load case {name}: the load factor {found[name].values[0]:.4g}"
            warnings.append(_coarse(what, float(error[0])))
    rows = [names.index(name) for name in found]
    shapes = [by_node(problem.mesh, f.shapes) for f in found.values()]
    return ShellBuckling(
        case=np.repeat(rows, [len(f.values) for f in found.values()]).astype(np.int64),
        factors=np.concatenate([np.zeros(0), *(f.values for f in found.values())]),
        shapes_G=np.concatenate([np.zeros((0, problem.mesh.n_node, 6)), *shapes]),
        reversed=np.array([found[name].reversed if name in found else 0.0 for name in names]),
        error=None if errors is None else np.concatenate([np.zeros(0), *errors.values()]),
    )


def by_node(mesh: ShellMesh, u: Array) -> Array:
    """Displacements (n_dof, m) of the nodes of the mesh, (m, n, 6)."""
    return np.moveaxis(u.reshape(len(u) // 6, 6, u.shape[1])[: mesh.n_node], 2, 0)


def _locked(problem: ShellProblem, shapes: Array, first: int) -> Warnings:
    names = [f"mode {first + i + 1}" for i in range(shapes.shape[1])]
    return warped_warnings(problem, shapes, names)


def _coarse(what: str, error: float) -> dict[str, str]:
    text = (
        f"{what} is about {100.0 * abs(error):.2g} % too {'high' if error > 0.0 else 'low'} "
        "by its mesh; use smaller cells: refine = 1 in [mesh]"
    )
    return {"code": "shell-mesh-coarse", "message": text}
