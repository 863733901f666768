"""Named groups of a shell: nodes of a physical point, curve or surface, with their weights."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ....solver.errors import did_you_mean, few
from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import corner_areas
from ..errors import ShellError
from .mesh import ShellMesh


class Group(NamedTuple):
    """Nodes that share a load by length of the edges, by area of the cells, or equally."""

    name: str
    kind: str  # "point", "curve" or "surface"
    nodes: IntArray  # (k,) ascending
    weights: Array  # (k,) length/2 of each edge [m], area/3 of each cell [m2], or 1 [-]
    centre_G: Array  # (3,) weighted                        [m]


def united(mesh: ShellMesh, names: str | Sequence[str], where: str) -> Group:
    """The groups with these names as one; nodes that they share have the sum of their weights.

    Raises ShellError for an unknown name, a name twice, and groups of different kinds.
    """
    listed = [names] if isinstance(names, str) else list(names)
    parts = [group(mesh, str(name), where) for name in listed]
    if not parts or len(set(listed)) < len(listed) or len({part.kind for part in parts}) > 1:
        raise ShellError(
            f"{where} = {listed}: expected names of points, of curves or of surfaces, each once"
        )
    if len(parts) == 1:
        return parts[0]
    nodes = np.concatenate([part.nodes for part in parts])
    weights = np.concatenate([part.weights for part in parts])
    return _gathered(mesh, " + ".join(listed), parts[0].kind, nodes, weights)


def group(mesh: ShellMesh, name: str, where: str) -> Group:
    """The group with this name. Raises ShellError for an unknown or an ambiguous name."""
    kinds: Mapping[str, Mapping[str, object] | tuple[str, ...]] = {
        "point": mesh.marks,
        "curve": mesh.curves,
        "surface": mesh.regions,
    }
    found = [kind for kind, names in kinds.items() if name in names]
    if not found:
        known = [str(known) for names in kinds.values() for known in names]
        raise ShellError(
            f"{where} = {name!r}: no physical group of that name; the mesh has "
            + (few(known) or "none")
            + did_you_mean(name, known)
        )
    if len(found) > 1:
        raise ShellError(
            f"{where} = {name!r}: a {' and a '.join(found)} have this name; give them different "
            "names in gmsh"
        )
    if found[0] == "point":
        nodes = mesh.marks[name]
        return _gathered(mesh, name, "point", nodes, np.ones(len(nodes)))
    if found[0] == "curve":
        ends = mesh.curves[name]
        length = np.linalg.norm(np.diff(mesh.points_G[ends], axis=1)[:, 0], axis=1)
        return _gathered(mesh, name, "curve", ends, np.repeat(length / 2.0, 2))
    nodes, shares = corner_areas(mesh.points_G, mesh.cells[mesh.region == mesh.regions.index(name)])
    return _gathered(mesh, name, "surface", nodes, shares)


def nearest_node(mesh: ShellMesh, place_G: Array) -> Group:
    """The node nearest to a position, as a group of one."""
    node = int(np.argmin(np.linalg.norm(mesh.points_G - place_G, axis=1)))
    name = "near ({:.4g}, {:.4g}, {:.4g})".format(*place_G)
    return _gathered(mesh, name, "point", np.array([node]), np.ones(1))


def _gathered(mesh: ShellMesh, name: str, kind: str, nodes: IntArray, shares: Array) -> Group:
    every = np.bincount(nodes.ravel(), weights=shares, minlength=mesh.n_node)
    unique = np.unique(nodes)
    weights = np.asarray(every[unique], dtype=float)
    centre = weights @ mesh.points_G[unique] / weights.sum()
    return Group(name, kind, unique, weights, centre)
