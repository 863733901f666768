"""Natural modes and load factors of a shell, in the order of its mesh file, with their errors."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.shell.schema import ShellBuckling, ShellModes
from ..cells import DOFS
from ..mesh import ShellMesh
from ..model.freedom import Freedom
from ..model.guards import Progress, Warnings, drilling_warning, zero_energy_warnings
from ..model.problem import mode_count
from ..model.states import warped_warnings
from .buckling import Stressed, buckled, buckling, check_stable
from .cases import by_node
from .discretisation import FinerMesh, frequency_errors, load_factor_errors
from .frequencies import natural_modes

COARSE = 0.05  # estimated error of a first load factor, or a frequency, that is warned about
CHEAP = 4000  # unknowns up to which errors of frequencies are estimated by default: half a second


def shell_modes(
    stressed: Stressed, finer: FinerMesh, warnings: Warnings, begin: Progress
) -> tuple[ShellModes | None, str]:
    """The natural modes that the specification asks for, None without [frequencies], and why their
    errors are not estimated, empty if they are."""
    problem = stressed.problem
    table = problem.spec.get("frequencies")
    if table is None:
        return None, ""
    count = mode_count(table, f"{problem.where}.frequencies")
    mesh, freedom = problem.mesh, problem.modes_freedom
    free = table.get("free", False)
    if free:
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
    elastic = range(found.n_zero, found.shapes.shape[1])
    locked = warped_warnings(problem, found.shapes[:, elastic], [f"mode {i + 1}" for i in elastic])
    warnings += locked
    values = np.where(np.arange(len(found.values)) < found.n_zero, 0.0, found.values)
    if case is not None and (values < 0.0).any():
        raise buckled(case, where)
    error, left_out = None, _left_out(table, mesh)
    if not left_out:
        error = frequency_errors(finer, case, np.sqrt(values), found.shapes, found.n_zero, free)
        if error is None:
            left_out = f"not possible on a mesh of half the cell size, {finer.unknowns} unknowns"
    # of cells that lock the other warning names the cause; a finer mesh of them is far off, too
    if error is not None and not locked and (np.abs(error) > COARSE).any():
        warnings.append(_coarse_frequencies(np.sqrt(values), error, found.n_zero))
    modes = ShellModes(
        np.sqrt(values),
        by_node(mesh, found.shapes),
        problem.resultants(found.shapes),
        found.n_zero,
        error,
    )
    return modes, left_out


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


def _left_out(table: Mapping[str, Any], mesh: ShellMesh) -> str:
    """Why the errors of frequencies are not estimated; empty if they are."""
    asked = table.get("error")
    if asked is False:
        return "error = false in [frequencies]"
    if asked is None and DOFS * mesh.n_node > CHEAP:
        return (
            f"above {CHEAP} unknowns the estimate takes several times as long as the frequencies; "
            "ask for it by error = true in [frequencies]"
        )
    return ""


def _coarse_frequencies(values: Array, error: Array, n_zero: int) -> dict[str, str]:
    """The warning about the frequency with the largest error of the mesh."""
    bad = np.flatnonzero(np.abs(error) > COARSE)
    worst = int(bad[np.argmax(np.abs(error[bad]))])
    more = "" if bad.size == 1 else f" (worst of {bad.size})"
    hertz = values[worst] / (2.0 * np.pi)
    what = f"frequency {worst - n_zero + 1}, {hertz:.4g} Hz{more}"
    return _coarse(what, float(error[worst]))


def _coarse(what: str, error: float) -> dict[str, str]:
    text = (
        f"{what} is about {100.0 * abs(error):.2g} % too {'high' if error > 0.0 else 'low'} "
        "by its mesh; use smaller cells: refine = 1 in [mesh]"
    )
    return {"code": "shell-mesh-coarse", "message": text}
