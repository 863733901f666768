"""Links: a reference point with six degrees of freedom that drives, or follows, a group of nodes.

    "rigid"    (RBE2) every node of the group follows the reference point as a rigid body:
               u_i = u_r + theta_r x d_i, theta_i = theta_r. The group cannot deform.
    "average"  (RBE3) the reference point follows the group: its motion is the best-fitting rigid
    motion
               of the group, by weighted least squares of displacements.
               A force or moment on it is distributed over the group with exactly its resultant.

If displacements do not determine a rotation (nodes on a line, or one node), the mean of the nodal
rotations about that axis is used.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....solver.errors import did_you_mean
from ....solver.math.arrays import Array
from ....solver.package.specification import SHELL_LINK_KINDS
from ..errors import ShellError
from ..mesh.axes import vector
from ..mesh.groups import Group, united
from ..mesh.mesh import ShellMesh

OPEN = 1e-8  # second moment about an axis over the largest: below it the rotation is undetermined


@dataclass(frozen=True)
class Link:
    """A reference point and its group of nodes."""

    name: str
    kind: str  # one of SHELL_LINK_KINDS
    group: Group
    point_G: Array  # (3,)                                  [m]
    rows: Array | None = None  # (6, k, 6) of a section link: motion from those of the nodes


def read_links(table: Mapping[str, Any], mesh: ShellMesh, where: str) -> list[Link]:
    """The links of a specification: {name: {at, kind, point}}; `at` is a group or a list of them,
    the default of point the centre of all.

    Raises ShellError for an unknown group or kind, and for a node in two rigid links.
    """
    links = []
    owner: dict[int, str] = {}
    for name, entry in table.items():
        place = f"{where}.{name}"
        kind = entry.get("kind")
        if kind not in SHELL_LINK_KINDS:
            raise ShellError(
                f"{place}.kind = {kind!r}: expected one of {', '.join(SHELL_LINK_KINDS)}"
                + did_you_mean(str(kind), SHELL_LINK_KINDS)
            )
        of = united(mesh, entry.get("at", ""), f"{place}.at")
        point = entry.get("point")
        centre = of.centre_G if point is None else vector(point, f"{place}.point")
        links.append(Link(name, kind, of, centre))
        for node in of.nodes.tolist() if kind == "rigid" else ():
            if node in owner:
                raise ShellError(
                    f"{place}.at = {of.name!r}: shares a node with the rigid link "
                    f"{owner[node]!r}; a node follows one reference point only"
                )
            owner[node] = name
    return links


def cross_matrix(a: Array) -> Array:
    """Matrices a~ with a~ b = a x b, (..., 3, 3) of vectors (..., 3)."""
    out = np.zeros((*a.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i, j], out[..., j, i] = -a[..., k], a[..., k]
    return out


def carried(arms_G: Array) -> Array:
    """Displacement and rotation of nodes that follow a point, (k, 6, 6): u = u_r + theta_r x d."""
    out = np.tile(np.eye(6), (len(arms_G), 1, 1))
    out[:, :3, 3:] = -cross_matrix(arms_G)
    return out


def averaged(arms_G: Array, weights: Array) -> Array:
    """Motion of the reference point from those of the nodes, (6, k, 6).

    Parameters
    ----------
    arms_G : (k, 3) from the reference point to the nodes [m]
    weights : (k,) above 0
    """
    share = weights / weights.sum()
    centre = share @ arms_G
    arms = arms_G - centre
    cross = cross_matrix(arms)
    inertia = np.einsum("k,kji,kjl->il", share, cross, cross)
    value, axis = np.linalg.eigh(inertia)
    length = np.linalg.norm(arms_G, axis=1).max(initial=0.0)
    open_ = value <= OPEN * max(value[-1], 1e-12 * length**2, 1e-300)
    known, left = axis[:, ~open_], axis[:, open_]
    inverse = known @ np.diag(1.0 / value[~open_]) @ known.T
    out = np.zeros((6, len(arms), 6))
    # angular momentum of the displacements over the second moment, then the mean of rotations
    out[3:, :, :3] = np.einsum("ij,kjl,k->ikl", inverse, cross, share)
    out[3:, :, 3:] = np.einsum("ij,k->ikj", left @ left.T, share)
    # the displacement of the centre, transferred to the reference point: - theta x centre
    out[:3, :, :3] = np.einsum("ij,k->ikj", np.eye(3), share)
    out[:3] += np.einsum("ij,jkl->ikl", cross_matrix(centre), out[3:])
    return out
