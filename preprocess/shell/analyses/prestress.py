"""Stiffness of a shell under the stresses of its load cases; load factors of buckling."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from ....solver.errors import did_you_mean
from ....solver.math.arrays import Array
from ... import fenicsx
from ..errors import ShellError
from ..model.guards import check_supported
from ..model.problem import ShellProblem
from .buckling import Buckling, LoadFactors

LARGE = 0.1  # rad, rotation at the first load factor above which linear buckling is doubtful
IN_PLANE = 0.1  # out of the plane over the largest motion: less is a motion in the plane
FLAT = 1e-6  # height of a flat shell over its size


class Stressed:
    """A shell with the displacements of its load cases.

    Parameters
    ----------
    names : of the load cases
    u : (n_dof, l) their displacements
    """

    def __init__(self, problem: ShellProblem, names: Sequence[str], u: Array) -> None:
        self.problem, self.names, self.u = problem, tuple(names), u

    def geometric(self, case: str, where: str, in_plane: bool = True) -> sp.csr_matrix:
        """Geometric stiffness of a load case, with that of its pressures, which follow the surface.

        Raises ShellError for an unknown case.
        """
        problem, row = self.problem, self._row(case, where)
        Kg = problem.geometric_stiffness(self.u[:, row], in_plane)
        loads = problem.spec["loads"][case]
        p = problem.loads.pressures(loads, f"{problem.where}.loads.{case}")
        if not p.any():
            return Kg
        Kp = problem.pressure_stiffness(p)
        return _sum(Kg, Kp)

    def stiffness(self, case: str | None, where: str, in_plane: bool = True) -> sp.csr_matrix:
        """Stiffness under a load case; without one that of the unloaded shell."""
        if case is None:
            return self.problem.K
        return _sum(self.problem.K, self.geometric(case, where, in_plane))

    def rotation(self, case: str) -> float:
        """Largest rotation in a load case [rad]."""
        turned = self.u[:, self.names.index(case)].reshape(-1, 6)[:, 3:]
        return float(np.linalg.norm(turned, axis=1).max(initial=0.0))

    def _row(self, case: str, where: str) -> int:
        if case not in self.names:
            raise ShellError(
                f"{where} = {case!r}: no load case of that name; expected one of "
                + (", ".join(self.names) or "those of tables loads.CASE")
                + did_you_mean(case, self.names)
            )
        return self.names.index(case)


def _sum(A: sp.csr_matrix, B: sp.csr_matrix) -> sp.csr_matrix:
    """A + B, with the zeros of matrices of one pattern, which `Freedom` then knows."""
    if np.array_equal(A.indices, B.indices) and np.array_equal(A.indptr, B.indptr):
        return sp.csr_matrix((A.data + B.data, A.indices, A.indptr), shape=A.shape)
    return sp.csr_matrix(A + B)  # with stiffeners


def check_stable(K: sp.csr_matrix, problem: ShellProblem, case: str, where: str) -> None:
    """Raise ShellError if the shell has buckled under the stresses of a load case.

    K : (n, n) its stiffness of the free degrees of freedom, without free motions
    """
    try:
        negative = fenicsx.negative_pivots(K, problem.team)
    except fenicsx.InertiaError as error:
        raise ShellError(f"{where} = {case!r}: {error}") from error
    if negative:
        raise buckled(case, where)


def buckled(case: str, where: str) -> ShellError:
    """The error of a shell that does not vibrate about its prestress."""
    return ShellError(
        f"{where} = {case!r}: the shell has buckled under this load case and does not vibrate; "
        "expected a smaller load: its load factor, which `--buckling` gives, has to be above 1"
    )


def buckling(
    stressed: Stressed, table: Mapping[str, Any], where: str, warnings: list[dict[str, str]]
) -> dict[str, LoadFactors]:
    """Load factors of load cases by name.

    Parameters
    ----------
    table : {"count": 4, "cases": [..], "constant": case, "in_plane": true}, all optional: number
        of factors; load cases that are multiplied, all of them by default except the constant
        one; a load case whose stress is constant; work on rotations about the normal
    where : key of the table, for messages
    warnings : appended to

    Raises
    ------
    ShellError : no load case, an unknown one, free rigid motions.
    """
    problem = stressed.problem
    count, in_plane = table.get("count", 4), table.get("in_plane", True)
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise ShellError(f"{where}.count = {count!r}: expected a whole number above 0")
    constant = table.get("constant")
    cases = table.get("cases")
    if cases is None:
        cases = [name for name in stressed.names if name != constant]
    if not cases:
        raise ShellError(f"{where}: expected load cases, tables loads.CASE.NAME")
    freedom = problem.modes_freedom
    check_supported(freedom, *problem.free_motions(freedom))
    K = stressed.stiffness(constant, f"{where}.constant", in_plane)
    equations = Buckling(K, freedom, where, problem.team)
    found = {}
    for name in cases:
        Kg = stressed.geometric(name, f"{where}.cases", in_plane)
        found[name] = equations.load_factors(Kg, count, f"{where}, load case {name}")
        first = found[name].values[:1]
        turned = stressed.rotation(name) * float(first[0]) if len(first) else 0.0
        if turned > LARGE:
            text = (
                f"load case {name}: at the load factor {first[0]:.4g} the shell has turned by "
                f"{np.degrees(turned):.3g} deg, more than {np.degrees(LARGE):.3g}: linear buckling "
                "assumes small displacements up to buckling; the real load may be far below"
            )
            warnings.append({"code": "buckling-after-large-rotation", "message": text})
        if len(first) and _moves_in_plane(problem.mesh.points_G, found[name].shapes[:, 0]):
            text = (
                f"load case {name}: the mode of the factor {first[0]:.4g} moves in the plane of "
                "the shell: a column, or a rotation that supports hold at one node only (hold the "
                "plane at two nodes); in_plane = false leaves such modes out"
            )
            warnings.append({"code": "buckles-in-plane", "message": text})
    equations.close()
    return found


def _moves_in_plane(points_G: Array, shape: Array) -> bool:
    """Whether a flat shell with nodes (n, 3) has a mode (6 n,) in its plane."""
    away = points_G - points_G.mean(axis=0)
    size, axes = np.linalg.svd(away, full_matrices=False)[1:]
    motion = shape.reshape(-1, 6)[:, :3]
    out = float(np.abs(motion @ axes[2]).max())
    return bool(size[2] < FLAT * size[0] and out < IN_PLANE * np.abs(motion).max())
