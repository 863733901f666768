"""Strain energies and frequencies of a shell by a second route: `plymotion shell --verify`.

The second route (second_route.py) reads supports and loads from the description itself. Both
routes solve the mesh and the one of half the cell size, and the finer results are compared. The
steps from the coarser to the finer ones bound what the mesh explains: an error of first order, as
at a corner, is halved, and others fall faster.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ....solver.math.arrays import Array, IntArray
from ....solver.package.shell.schema import ShellCases, ShellModes
from ... import fenicsx
from ..errors import ShellError
from ..model.guards import COINCIDENT
from ..model.loads import KINDS
from ..model.problem import ShellProblem
from ..model.supports import COMPONENTS, fixed_components
from .discretisation import REST, FinerMesh, frequency_errors
from .second_route import SecondRoute

LARGEST = 0.02  # relative difference that two right routes may have beyond that of the meshes
COARSE = 0.2  # relative step from one mesh to the next above which nothing is judged
MOST = 200_000  # unknowns of the second route on the finer mesh
PER_NODE = 3.5  # unknowns of the second route over those of this one: 21 for a node, not 6
ZERO = 1e-3  # of the lowest elastic eigenvalue: those below are rigid motions


class Verified(NamedTuple):
    """Outcome of a verification in words, and a finding or none."""

    words: str
    warnings: list[dict[str, str]]


class _NotDone(Exception):
    """What the second route does not have, in words."""


def verified(
    problem: ShellProblem, finer: FinerMesh, cases: ShellCases, modes: ShellModes | None
) -> Verified:
    """Compare strain energies of load cases, and frequencies, with those of the second route.

    Parameters
    ----------
    cases, modes : results of the engine on the mesh of the problem
    """
    try:
        found = _both(problem, finer, cases, modes)
    except _NotDone as reason:
        return Verified(f"not done for {reason}", [])
    except (fenicsx.EigenError, fenicsx.FactorisationError, ShellError) as error:
        return Verified(f"not done: {error}", [])
    judged, coarse = [], []
    for name, values in found.items():
        ours, ours_finer, other, other_finer = (float(value) for value in values)
        size = max(abs(ours_finer), abs(other_finer)) or 1.0
        steps = abs(ours - ours_finer) / size, abs(other - other_finer) / size
        if max(steps) > COARSE:
            coarse.append(name)
        else:
            judged.append((abs(ours_finer - other_finer) / size, sum(steps), name))
    left = f"the mesh is too coarse for {', '.join(coarse)}" if coarse else ""
    if not judged:
        return Verified(f"not done: {left}", [])
    gap, step, name = max(judged, key=lambda one: one[0] - one[1])
    words = f"{name}: difference {100.0 * gap:.2g} %, of which meshes explain {100.0 * step:.2g} %"
    finding = {"code": "verification-differs", "message": f"{words}: please report the shell"}
    warnings = [] if gap <= step + LARGEST else [finding]
    return Verified("; ".join(filter(None, (words, left))), warnings)


def _both(
    problem: ShellProblem, finer: FinerMesh, cases: ShellCases, modes: ShellModes | None
) -> dict[str, Array]:
    """Values (4,) of this route, on the mesh and the finer one, and of the other, by name."""
    mesh, table = problem.mesh, problem.spec.get("frequencies", {})
    vibrates = modes is not None and "prestress" not in table
    close = cKDTree(mesh.points_G).query_pairs(COINCIDENT * mesh.size)
    for what, there in {
        "links": problem.links,
        "stiffeners": problem.stiffeners,
        "a shell without load cases and unstressed modes": not cases.names and not vibrates,
        "nodes at the same position": close,
        f"more than {MOST} unknowns of the second method": PER_NODE * finer.unknowns > MOST,
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
    found, held = [], fixed(route, problem, "loads")
    for case in spec.get("loads", {}).values():
        rhs, given = right_side(route, problem, case)
        u = route.solve(rhs, held, given)
        found.append(0.5 * u @ (route.K @ u))
    if not len(elastic):
        return np.array(found)
    held = fixed(route, problem, "modes") * (not spec["frequencies"].get("free", False))
    lowest = float(elastic[0] ** 2)
    target = -lowest if n_zero else 0.0
    values = route.eigenvalues(len(elastic) + n_zero, held, target)
    values = values[values > ZERO * lowest][: len(elastic)]
    if len(values) < len(elastic):
        raise _NotDone("modes without strain energy that only one method has")
    return np.append(found, np.sqrt(values))


def fixed(route: SecondRoute, problem: ShellProblem, purpose: str) -> Array:
    """Which unknowns the supports hold for "loads" or "modes", (k,) booleans."""
    held = np.zeros(route.K.shape[0], dtype=bool)
    for name, entry in problem.spec.get("supports", {}).items():
        if entry.get("only") in (None, purpose):
            components = fixed_components(entry.get("fixed"), f"supports.{name}.fixed")
            at = entry["at"]
            for group in [at] if isinstance(at, str) else at:
                for component in components:
                    held[_unknowns(route, problem, group, component)] = True
    return held


def right_side(
    route: SecondRoute, problem: ShellProblem, case: Mapping[str, Any]
) -> tuple[Array, Array]:
    """Right-hand side of a load case, and the displacements that it gives to supports."""
    rhs, given = np.zeros((2, route.K.shape[0]))
    for entry in case.values():
        at = entry.get("at")
        for component, value in (entry.get("motion") or {}).items():
            given[_unknowns(route, problem, at, COMPONENTS.index(component))] = value
        for key in KINDS:
            if entry.get(key) is not None:
                rhs += _load(route, problem, key, entry)
    return rhs, given


def _unknowns(route: SecondRoute, problem: ShellProblem, name: str, component: int) -> IntArray:
    """Unknowns of one component of a physical group."""
    nodes, ends = _group(route, problem, name)
    sides = route.numbers(ends)
    if component >= 3:
        if not len(sides):
            raise _NotDone("a rotation held at a point")
        return route.turns[sides, component - 3]
    return route.u[np.append(nodes, len(route.points) + sides), component]


def _group(route: SecondRoute, problem: ShellProblem, name: str) -> tuple[IntArray, IntArray]:
    """Nodes and sides (k, 2) of a physical group; a point has no sides."""
    mesh = problem.mesh
    if name in mesh.marks:
        return mesh.marks[name], np.zeros((0, 2), dtype=np.int64)
    ends = mesh.curves.get(name)
    if ends is None:
        inside = mesh.region[route.rows] == mesh.regions.index(name)
        ends = route.sides[np.unique(route.of_cells[inside])]
    return np.unique(ends), ends


def _load(route: SecondRoute, problem: ShellProblem, key: str, entry: Mapping[str, Any]) -> Array:
    """Right-hand side of one load."""
    mesh, at, value = problem.mesh, entry.get("at"), np.array(entry[key], dtype=float)
    rhs = np.zeros(route.K.shape[0])
    if key == "gravity":
        rhs[route.u] = value
        return np.asarray(route.M @ rhs)
    if at in mesh.marks:
        if key == "moment":
            raise _NotDone("a moment at a point")
        np.add.at(rhs, route.u[mesh.marks[at]], value / len(mesh.marks[at]))
        return rhs
    if at in mesh.curves:
        ends = mesh.curves[at]
        length = np.linalg.norm(np.diff(mesh.points_G[ends], axis=1)[:, 0], axis=1)
        total = 1.0 if key == "force_per_length" else length.sum()
        share, sides = (length / total)[:, None] * value, route.numbers(ends)
        if key == "moment":
            np.add.at(rhs, route.turns[sides], share)
            return rhs
        for nodes, weight in ((ends[:, 0], 1), (ends[:, 1], 1), (len(route.points) + sides, 4)):
            np.add.at(rhs, route.u[nodes], weight / 6 * share)
        return rhs
    inside = np.ones(len(route.rows), dtype=bool)
    if at is not None:
        inside = mesh.region[route.rows] == mesh.regions.index(at)
    area = route.area[inside]
    if key == "moment":
        share = np.repeat(area / 3 / area.sum(), 3).reshape(-1, 3, 1)
        np.add.at(rhs, route.turns[route.of_cells[inside]], share * value)
        return rhs
    if key == "pressure":
        density = value * route.normal[inside]
    else:
        density = np.tile(value / (area.sum() if key == "force" else 1.0), (len(area), 1))
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
