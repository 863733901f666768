"""Load cases of a supported shell, one factorisation for all, and probes of their results."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ....solver.errors import check_known, coded
from ....solver.math.arrays import Array, IntArray
from ....solver.package.shell.shell_schema import (
    SHELL_MOTIONS,
    SHELL_RESULTANTS,
    ShellCases,
    ShellProbes,
)
from ... import fenicsx
from ..groups import Group, group, nearest_node, vector
from ..model.freedom import Freedom
from ..model.loads import resultant
from ..model.shell_problem import ShellProblem
from ..model.shell_warnings import Progress, Warnings, check_supported
from ..model.states import link_warnings, warped_warnings
from ..shell_cells import DOFS, ShellError, ShellMesh

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
    """Displacements and reactions under nodal forces.

    Parameters
    ----------
    K : (n_dof, n_dof) stiffness, of the cells of this process
    freedom : which degrees of freedom are free
    forces : (n_dof, l) [N, N m]
    names : of the l load cases
    team : processes that share the cells
    given : (n_dof, l) displacements of fixed degrees of freedom, zero elsewhere; None: none

    Raises
    ------
    ShellError : nothing to solve, or the stiffness is singular in spite of its supports.
    """
    if not freedom.n_free:
        raise ShellError("supports: every degree of freedom is fixed")
    reduced = freedom.reduced(K)
    moved = np.zeros_like(forces) if given is None else freedom.carried_along(given)
    loads = freedom.gathered(forces - team.total(K @ moved) if moved.any() else forces)
    # The bending stiffness of a thin shell is a million times smaller than its membrane stiffness.
    # The round-off of one solve depends on the order of elimination and changes the ninth digit.
    # With residuals in extended precision the result is the same for every factorisation.
    longer = reduced.astype(np.longdouble)
    try:
        factor = fenicsx.Cholesky(reduced, team)
        q = factor.solve(loads)
        for _ in range(STEPS):
            q = q + factor.solve(np.asarray(loads - team.total(longer @ q), dtype=float))
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
    warnings: Warnings = []
    for name, relative, stored, done in zip(names, residual, energy, work, strict=True):
        gap = abs(2.0 * stored - done) / (abs(done) or 1.0)
        if relative > RESIDUAL or gap > BALANCE:
            warnings += coded(
                "few-digits",
                f"load case {name}: residual {relative:.1e}, work and energy "
                f"differ by {gap:.1e} (relative): the stiffness is ill-conditioned, as for "
                "a very thin shell; the displacements have fewer correct digits",
            )
    return Statics(u, reactions, energy, residual, tuple(warnings))


KNOWN = (*SHELL_MOTIONS, *SHELL_RESULTANTS)


class Probe(NamedTuple):
    """One number per load case: a weighted mean."""

    name: str
    quantity: str  # of SHELL_MOTIONS or SHELL_RESULTANTS
    rows: IntArray  # (k,) degrees of freedom, or cells
    weights: Array  # (k,), sum 1


def read_probes(problem: ShellProblem) -> list[Probe]:
    """The probes of a specification: {name: {at or near, what}}; one for each quantity.

    A motion is the mean over the group's nodes (by length, area or number) or that of a link; a
    resultant the mean over the cells that touch the group, by area, or of a region.

    Raises ShellError for an unknown group or quantity.
    """
    probes = []
    for name, entry in problem.spec.get("probes", {}).items():
        where = f"{problem.where}.probes.{name}"
        what, expected = entry.get("what"), f"expected some of {', '.join(KNOWN)}"
        for quantity in [what] if isinstance(what, str) else what or []:
            check_known(quantity, KNOWN, f"{where}.what", ShellError, expected)
            probes.append(_probe(problem, name, quantity, entry, where))
        if not what:
            raise ShellError(f"{where}.what: missing, {expected}")
    return probes


def _probe(
    problem: ShellProblem, name: str, quantity: str, entry: Mapping[str, Any], where: str
) -> Probe:
    mesh, at, near = problem.mesh, entry.get("at"), entry.get("near")
    if (at is None) == (near is None):
        raise ShellError(f"{where}: expected at = ..., or near = [x, y, z]")
    if quantity in SHELL_MOTIONS:
        component = SHELL_MOTIONS.index(quantity)
        for row, link in enumerate(problem.links):
            if link.name == at:
                return Probe(
                    name, quantity, np.array([DOFS * (mesh.n_node + row) + component]), np.ones(1)
                )
        of = _place(problem, at, near, where)
        weights = of.weights / of.weights.sum()
        return Probe(name, quantity, DOFS * of.nodes + component, weights)
    area = np.linalg.norm(mesh.area_vectors_G, axis=1)
    if near is not None:
        middles = mesh.centres_G
        gap = np.linalg.norm(middles - vector(near, f"{where}.near"), axis=1)
        cells = np.array([int(np.argmin(gap))])
    elif at in mesh.regions:
        cells = np.flatnonzero(mesh.region == mesh.regions.index(str(at)))
    else:
        nodes = _place(problem, at, near, where).nodes
        cells = np.flatnonzero(np.isin(mesh.cells, nodes).any(axis=1))
    return Probe(name, quantity, cells, area[cells] / area[cells].sum())


def _place(problem: ShellProblem, at: Any, near: Any, where: str) -> Group:
    if near is not None:
        return nearest_node(problem.mesh, vector(near, f"{where}.near"))
    return group(problem.mesh, str(at), f"{where}.at")


def load_cases(
    problem: ShellProblem, warnings: Warnings, begin: Progress
) -> tuple[ShellCases, ShellProbes, Array]:
    """Results of all load cases, values of probes, displacements (n_dof, l).

    Parameters
    ----------
    problem : the shell
    warnings : appended to
    begin : called with one line at the beginning of each step

    Raises
    ------
    ShellError : free rigid motions, a singular stiffness, a wrong load or probe.
    """
    spec, freedom, mesh = problem.spec, problem.freedom, problem.mesh
    probes = read_probes(problem)
    names = tuple(spec.get("loads", {}))
    forces, given = problem.loads.columns(spec.get("loads", {}), problem.where)
    u, energy, residual = np.zeros_like(forces), np.zeros(len(names)), np.zeros(len(names))
    reactions = np.zeros((len(names), len(problem.supports), 6))
    if names:
        check_supported(freedom, *problem.free_motions(freedom))
        begin(f"load cases, {freedom.n_free} unknowns")
        solved = solve_cases(problem.K, freedom, forces, names, problem.team, given)
        u, energy, residual = solved.displacements, solved.energy, solved.residual
        warnings += solved.warnings
        states = [f"load case {name}" for name in names]
        warnings += warped_warnings(problem, u, states)
        warnings += link_warnings(problem, u, forces, energy, names)
        taken = np.zeros(freedom.n_dof, dtype=bool)
        for row, support in enumerate(problem.supports):
            own = np.zeros_like(forces)
            dofs = support.dofs[
                ~taken[support.dofs]
            ]  # a node held by two supports is reported with the first
            own[dofs] = solved.reactions[dofs]
            taken[dofs] = True
            reactions[:, row] = resultant(mesh, freedom, own, support.point_G).T
    resultants = problem.resultants(u)
    cases = ShellCases(
        names=names,
        displacements_G=by_node(mesh, u),
        resultants_E=resultants,
        link_motions_G=np.moveaxis(u.reshape(len(u) // 6, 6, len(names))[mesh.n_node :], 2, 0),
        loads_G=resultant(mesh, freedom, forces, np.zeros(3)).T,
        reactions_G=reactions,
        energy=energy,
        residual=residual,
    )
    values = np.empty((len(names), len(probes)))
    for column, probe in enumerate(probes):
        if probe.quantity in SHELL_MOTIONS:
            values[:, column] = probe.weights @ u[probe.rows]
        else:
            row = SHELL_RESULTANTS.index(probe.quantity)
            values[:, column] = resultants[:, probe.rows, row] @ probe.weights
    of_probes = tuple(probe.name for probe in probes), tuple(probe.quantity for probe in probes)
    return cases, ShellProbes(*of_probes, values), u


def by_node(mesh: ShellMesh, u: Array) -> Array:
    """Displacements (n_dof, m) of the nodes of the mesh, (m, n, 6)."""
    return np.moveaxis(u.reshape(len(u) // 6, 6, u.shape[1])[: mesh.n_node], 2, 0)
