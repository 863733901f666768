"""Strain energies and frequencies of a shell by a second route: `plymotion shell --verify`.

The second route (second_route.py) reads supports and loads from the description itself. Both
routes solve the mesh and the one of half the cell size, and the finer results are compared. The
steps from the coarser to the finer ones bound what the mesh explains: an error of first order, as
at a corner, is halved, and others fall faster.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ....solver.errors import coded
from ....solver.math.arrays import Array, IntArray
from ....solver.package.shell.shell_schema import ShellCases, ShellModes
from ... import fenicsx
from ..model.loads import KINDS
from ..model.shell_problem import ShellProblem
from ..model.shell_warnings import COINCIDENT
from ..model.supports import COMPONENTS, fixed_components
from ..shell_cells import ShellError
from .discretisation import REST, FinerMesh, at_points, frequency_errors
from .modes import WARPED
from .second_route import SecondRoute

LARGEST = 0.02  # relative difference that two right routes may have beyond that of the meshes
COARSE = 0.2  # relative step from one mesh to the next above which nothing is judged
# The same under a moment at a point, which without a stiffener has no limit: halving the cells adds
# equal parts, and both routes differ by 1.65 times the steps: here by less than 2 % beyond them.
SINGULAR = 0.015
# Offset of a wall over its thickness above which the second route locks: its rotations jump at
# sides, its displacements do not. Plates of 2 x 2 to 16 x 16 cells agree up to 3, some differ at 5.
FAR = 3.0
MOST = 500_000  # unknowns of the second route on the finer mesh: 2.4 GB
PER_NODE = 3.5  # unknowns of the second route over those of this one: 21 for a node, not 6
ZERO = 1e-3  # of the lowest elastic eigenvalue: those below are rigid motions


class Verified(NamedTuple):
    """Outcome of a verification in words, and a finding or none."""

    words: str
    warnings: list[dict[str, str]]


class _NotDone(Exception):
    """What the second route does not have, in words."""


def verified(
    problem: ShellProblem,
    finer: FinerMesh,
    cases: ShellCases,
    modes: ShellModes | None,
    warnings: Sequence[Mapping[str, str]] = (),
) -> Verified:
    """Compare strain energies of load cases, and frequencies, with those of the second route.

    Parameters
    ----------
    cases, modes : results of the engine on the mesh of the problem
    warnings : warnings about them; of cells that lock, no difference is a finding
    """
    try:
        both = _both(problem, finer, cases, modes)
    except _NotDone as reason:
        return Verified(f"not done for {reason}", [])
    except (fenicsx.EigenError, fenicsx.FactorisationError, ShellError) as error:
        return Verified(f"not done: {error}", [])
    judged: list[tuple[float, float, str]] = []
    coarse: list[str] = []
    singular: list[str] = []
    moments = [f"strain energy of {name}" for name in at_points(problem, "moment")]
    for name, values in both.items():
        ours, ours_finer, other, other_finer = (float(value) for value in values)
        size = max(abs(ours_finer), abs(other_finer)) or 1.0
        steps = abs(ours - ours_finer) / size, abs(other - other_finer) / size
        if max(steps) > (SINGULAR if name in moments else COARSE):
            (singular if name in moments else coarse).append(name)
        else:
            judged.append((abs(ours_finer - other_finer) / size, sum(steps), name))
    left = "; ".join(
        f"{why} {', '.join(names)}"
        for why, names in (
            ("the mesh is too coarse for", coarse),
            ("a moment at a point has no limit for finer cells in", singular),
        )
        if names
    )
    if not judged:
        return Verified(f"not done: {left}", [])
    gap, step, name = max(judged, key=lambda one: one[0] - one[1])
    text = f"{name}: difference {100.0 * gap:.2g} %, of which meshes explain {100.0 * step:.2g} %"
    differs = gap > step + LARGEST
    if differs and WARPED & {warning["code"] for warning in warnings}:
        return Verified(f"{text}: cells lock, see the warnings", [])
    walls = (region.laminate.laminate for region in problem.regions)
    if differs and any(abs(wall.offset) > FAR * wall.thickness for wall in walls):
        return Verified(f"{text}: the second method is too stiff for offsets of a wall", [])
    finding = coded("verification-differs", f"{text}: please report the shell")
    return Verified("; ".join(filter(None, (text, left))), finding if differs else [])


def _both(
    problem: ShellProblem, finer: FinerMesh, cases: ShellCases, modes: ShellModes | None
) -> dict[str, Array]:
    """Values (4,) of this route, on the mesh and the finer one, and of the other, by name."""
    mesh, table = problem.mesh, problem.spec.get("frequencies", {})
    vibrates = modes is not None and "prestress" not in table
    unknowns = int(PER_NODE * finer.unknowns)
    close = cKDTree(mesh.points_G).query_pairs(COINCIDENT * mesh.size)
    for what, there in {
        "a shell without load cases and unstressed modes": not cases.names and not vibrates,
        "nodes at the same position": close,
        f"about {unknowns} unknowns of the second method on a mesh of half the cell size, expected "
        f"at most {MOST}: verify the same shell with larger cells": unknowns > MOST,
    }.items():
        if there:
            raise _NotDone(what)
    u = finer.stressed.u
    ours = [cases.energy, 0.5 * np.einsum("nl,nl->l", u, finer.problem.K @ u)]
    names = [f"strain energy of {name}" for name in cases.names]
    elastic, zero, free = np.zeros(0), 0, table.get("free", False)
    if modes is not None and vibrates:
        zero, error = modes.n_zero, modes.error
        elastic = modes.frequencies[zero:]
        if error is None:
            shapes = modes.shapes_G.reshape(len(modes.frequencies), -1).T
            error = frequency_errors(finer, None, modes.frequencies, shapes, zero, free)
        if error is None:
            raise _NotDone("frequencies that a finer mesh does not have")
        share = error[zero:] / (1.0 + error[zero:]) / REST
        ours = [np.append(ours[0], elastic), np.append(ours[1], elastic * (1.0 - share))]
        names += [f"frequency {row + 1}" for row in range(len(elastic))]
    other = [_second(one, elastic, zero) for one in (problem, finer.problem)]
    return dict(zip(names, np.stack([*ours, *other], axis=1), strict=True))


def _second(problem: ShellProblem, elastic: Array, n_zero: int) -> Array:
    """Strain energies [J], then as many frequencies [rad/s] as `elastic` has, behind n_zero."""
    route, spec = SecondRoute(problem), problem.spec
    energies, held = [], fixed(route, problem, "loads")
    for case in spec.get("loads", {}).values():
        rhs, given = right_side(route, problem, case)
        u = route.solve(rhs, held, given)
        energies.append(0.5 * u @ (route.K @ u))
    if not len(elastic):
        return np.array(energies)
    held = fixed(route, problem, "modes") * (not spec["frequencies"].get("free", False))
    lowest = float(elastic[0] ** 2)
    target = -lowest if n_zero else 0.0
    values = route.eigenvalues(len(elastic) + n_zero, held, target)
    values = values[values > ZERO * lowest][: len(elastic)]
    if len(values) < len(elastic):
        raise _NotDone("modes without strain energy that only one method has")
    return np.append(energies, np.sqrt(values))


def fixed(route: SecondRoute, problem: ShellProblem, purpose: str) -> Array:
    """Which unknowns the supports hold, (k,) booleans.

    Parameters
    ----------
    route : the shell by the second method
    problem : the shell, with its supports
    purpose : "loads" or "modes"
    """
    held = np.zeros(route.K.shape[0], dtype=bool)
    for name, entry in problem.spec.get("supports", {}).items():
        if entry.get("only") in (None, purpose):
            for component in fixed_components(entry.get("fixed"), f"supports.{name}.fixed"):
                held[_unknowns(route, problem, entry["at"], component)] = True
    return held


def right_side(
    route: SecondRoute, problem: ShellProblem, case: Mapping[str, Any]
) -> tuple[Array, Array]:
    """Right-hand side of a load case, and the displacements that it gives to supports.

    Parameters
    ----------
    route : the shell by the second method
    problem : the shell
    case : loads by name
    """
    rhs, given = np.zeros((2, route.K.shape[0]))
    for entry in case.values():
        at = entry.get("at")
        for component, value in (entry.get("motion") or {}).items():
            given[_unknowns(route, problem, at, COMPONENTS.index(component))] = value
        for key in KINDS:
            if entry.get(key) is not None:
                rhs += _load(route, problem, key, entry)
    return rhs, given


def _unknowns(route: SecondRoute, problem: ShellProblem, names: Any, component: int) -> IntArray:
    """Unknowns of one component of physical groups, or of the point of a link."""
    for link, point in zip(problem.links, route.parts.points, strict=True):
        if link.name == names:
            return point[[component]]
    group = route.spread(names)
    if component < 3:
        return route.u[group.at, component]
    nodes = group.at[group.at < len(route.points)]
    stiffened = route.parts.turns[nodes, component - 3]
    if not set(np.ravel(names)).isdisjoint(problem.mesh.marks):
        if (stiffened < 0).any():
            raise _NotDone("a rotation held at a point")
        return stiffened
    return np.append(route.turns[group.sides, component - 3], stiffened[stiffened >= 0])


def _load(route: SecondRoute, problem: ShellProblem, key: str, entry: Mapping[str, Any]) -> Array:
    """Right-hand side of one load."""
    mesh, at, value = problem.mesh, entry.get("at"), np.array(entry[key], dtype=float)
    rhs = np.zeros(route.K.shape[0])
    if key == "gravity":
        rhs[route.u] = value
        return np.asarray(route.M @ rhs)
    for link, point in zip(problem.links, route.parts.points, strict=True):
        if link.name == at:
            rhs[point[3:] if key == "moment" else point[:3]] = value
            return rhs
    if key in ("force", "moment", "force_per_length"):
        group = route.spread(at)
        rows, weights = route.u[group.at], group.weights
        if key == "moment":
            rows, weights = route.turns[group.sides], group.turn_weights
            if at in mesh.marks and (route.parts.turns[group.at] >= 0).all():  # of stiffeners
                rows, weights = route.parts.turns[group.at], group.weights
        total = 1.0 if key == "force_per_length" else weights.sum()
        np.add.at(rhs, rows, weights[:, None] / total * value)
        return rhs
    inside = np.ones(len(route.rows), dtype=bool)
    if at is not None:
        inside = mesh.region[route.rows] == mesh.regions.index(at)
    area = route.area[inside]
    density = value * (route.normal[inside] if key == "pressure" else np.ones((len(area), 1)))
    cells, sides = route.cells[inside], route.of_cells[inside]
    nodes = np.concatenate([cells, len(route.points) + sides], axis=1)
    sine = np.array(entry.get("sine") or [0.0, 0.0, 0.0])
    points, weights = fenicsx.quadrature("triangle", 4)
    for (x, y), weight in zip(points, weights, strict=True):
        L = np.array([1.0 - x - y, x, y])
        functions = np.append(L * (2.0 * L - 1.0), 4.0 * L[[1, 2, 0]] * L[[2, 0, 1]])
        places = L @ mesh.points_G[cells]
        waves = np.where(
            sine != 0.0, np.sin(np.pi * places / np.where(sine != 0.0, sine, 1.0)), 1.0
        )
        scale = 2.0 * weight * area * waves.prod(axis=1)
        np.add.at(rhs, route.u[nodes], np.einsum("c,k,ci->cki", scale, functions, density))
    return rhs
