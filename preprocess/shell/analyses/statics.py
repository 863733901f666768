"""Load cases of a supported shell: one factorisation for all cases."""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array
from ... import fenicsx
from ..errors import ShellError
from ..model.freedom import Freedom

RESIDUAL = 1e-9  # residual of the nodal equilibrium, relative to the load
STEPS = 2  # refinement steps; each adds as many digits as the first solve has
BALANCE = 1e-6  # relative difference of work and twice the energy


class Statics(NamedTuple):
    """Solutions of `l` load cases, on all degrees of freedom."""

    displacements: Array  # (n_dof, l)                      [m, rad]
    reactions: Array  # (n_dof, l) of supports on the shell [N, N m]
    energy: Array  # (l,) strain energy                     [J]
    residual: Array  # (l,) relative residual of equilibrium
    warnings: tuple[dict[str, str], ...]


def solve_cases(
    K: sp.csr_matrix,
    freedom: Freedom,
    forces: Array,
    names: tuple[str, ...],
    team: fenicsx.Team = fenicsx.ALONE,
    given: Array | None = None,
) -> Statics:
    """Displacements and reactions under nodal forces (n_dof, l).

    `given` (n_dof, l) are displacements of fixed degrees of freedom, zero elsewhere. Each process
    of a team has its part of K.

    Raises
    ------
    ShellError : nothing to solve, or the stiffness is singular in spite of its supports.
    """
    if not freedom.n_free:
        raise ShellError("supports: every degree of freedom is fixed")
    reduced = freedom.reduced(K)
    moved = np.zeros_like(forces) if given is None else freedom.carried_along(given)
    loads = freedom.gathered(forces - team.total(K @ moved) if moved.any() else forces)
    try:
        factor = fenicsx.Cholesky(reduced, team)
        q = _refined(factor, reduced, loads, team)
        factor.close()
    except fenicsx.FactorisationError as error:
        raise ShellError(f"statics: {error}") from error
    u = freedom.expanded(q) + moved
    out_of_balance = np.abs(team.total(reduced @ q) - loads)
    # the accuracy of a row is that of the terms that cancel in it
    size = team.total(abs(reduced) @ np.abs(q)).max(axis=0) + np.abs(loads).max(axis=0)
    residual = out_of_balance.max(axis=0) / np.where(size > 0.0, size, 1.0)
    Ku = team.total(K @ u)
    energy = 0.5 * np.einsum("nl,nl->l", u, Ku)
    reactions = freedom.on_supports(Ku - forces)
    work = np.einsum("nl,nl->l", u, forces)
    if given is not None:
        work += np.einsum("nl,nl->l", given, reactions)
    return Statics(
        u,
        reactions,
        energy,
        residual,
        tuple(_warnings(names, residual, energy, work)),
    )


def _refined(factor: fenicsx.Cholesky, K: sp.csr_matrix, loads: Array, team: fenicsx.Team) -> Array:
    """Solve with residuals in extended precision.

    The bending stiffness of a thin shell is a million times smaller than its membrane stiffness.
    The round-off of one solve depends on the order of elimination and changes the ninth digit. With
    refinement the result is the same for every factorisation of the same matrix.
    """
    longer = K.astype(np.longdouble)
    q = factor.solve(loads)
    for _ in range(STEPS):
        q = q + factor.solve(np.asarray(loads - team.total(longer @ q), dtype=float))
    return np.asarray(q)


def _warnings(
    names: tuple[str, ...], residual: Array, energy: Array, work: Array
) -> list[dict[str, str]]:
    found = []
    for name, relative, stored, done in zip(names, residual, energy, work, strict=True):
        gap = abs(2.0 * stored - done) / (abs(done) or 1.0)
        if relative > RESIDUAL or gap > BALANCE:
            found.append(
                {
                    "code": "few-digits",
                    "message": f"load case {name}: residual {relative:.1e}, work and energy "
                    f"differ by {gap:.1e} (relative): the stiffness is ill-conditioned, as for "
                    "a very thin shell; the displacements have fewer correct digits",
                }
            )
    return found
