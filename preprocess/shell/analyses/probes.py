"""Probes of a description: displacements and resultants at named places."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ....solver.errors import did_you_mean
from ....solver.math.arrays import Array, IntArray
from ....solver.package.shell.schema import SHELL_MOTIONS, SHELL_RESULTANTS
from ..errors import ShellError
from ..mesh.axes import vector
from ..mesh.groups import Group, group, nearest_node
from ..model.assembly import DOFS
from ..model.problem import ShellProblem

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
    found = []
    for name, entry in problem.spec.get("probes", {}).items():
        where = f"{problem.where}.probes.{name}"
        what = entry.get("what")
        for quantity in [what] if isinstance(what, str) else what or []:
            if quantity not in KNOWN:
                raise ShellError(
                    f"{where}.what = {quantity!r}: expected some of {', '.join(KNOWN)}"
                    + did_you_mean(str(quantity), KNOWN)
                )
            found.append(_probe(problem, name, quantity, entry, where))
        if not what:
            raise ShellError(f"{where}.what: missing, expected some of {', '.join(KNOWN)}")
    return found


def probe_values(probes: Sequence[Probe], u: Array, resultants_E: Array) -> Array:
    """Values of the probes: displacements (n_dof, l), resultants (l, c, 8) -> (l, o)."""
    out = np.empty((u.shape[1], len(probes)))
    for column, probe in enumerate(probes):
        if probe.quantity in SHELL_MOTIONS:
            out[:, column] = probe.weights @ u[probe.rows]
        else:
            row = SHELL_RESULTANTS.index(probe.quantity)
            out[:, column] = resultants_E[:, probe.rows, row] @ probe.weights
    return out


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
