"""Supports: fixed degrees of freedom of groups, and edges that are kept straight."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....solver.errors import check_known, did_you_mean
from ....solver.math.arrays import Array, IntArray
from ..groups import united
from ..shell_cells import DOFS, ShellError, ShellMesh
from .links import Link

COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")
# At a symmetry plane normal to an axis: no displacement along it, no rotation about the others.
WORDS = {
    "all": COMPONENTS,
    "symmetry-x": ("ux", "ry", "rz"),
    "symmetry-y": ("uy", "rx", "rz"),
    "symmetry-z": ("uz", "rx", "ry"),
}


ONLY = ("loads", "modes")  # load cases; natural modes and buckling


class Support(NamedTuple):
    """Fixed degrees of freedom of one group."""

    name: str
    dofs: IntArray  # (k,) of all, ascending
    point_G: Array  # (3,) reference point of its reaction moment [m]
    only: str | None = None  # one of ONLY, or None: in both


def read_supports(
    table: Mapping[str, Any], mesh: ShellMesh, links: Sequence[Link], where: str
) -> list[Support]:
    """The supports of a specification.

    Parameters
    ----------
    table : {name: {at, fixed, only}}; `at` is a group, several of one kind, or a link
    mesh : of the shell
    links : reference points, in their order
    where : key of the table, for messages

    Raises
    ------
    ShellError
        An unknown group or component; a support on the reference point of an average link.
    """
    rows = {link.name: i for i, link in enumerate(links)}
    supports = []
    for name, entry in table.items():
        place = f"{where}.{name}"
        components = fixed_components(entry.get("fixed"), f"{place}.fixed")
        at = entry.get("at", "")
        if isinstance(at, str) and at in rows:
            link = links[rows[at]]
            if link.kind != "rigid":
                raise ShellError(
                    f"{place}.at = {at!r}: an average link follows its group and cannot hold it; "
                    "expected a rigid link, or the group itself"
                )
            nodes, point = np.array([mesh.n_node + rows[at]]), link.point_G
        else:
            of = united(mesh, at, f"{place}.at")
            nodes, point = of.nodes, of.centre_G
        dofs = np.sort((DOFS * nodes[:, None] + components).ravel())
        only = entry.get("only")
        if only is not None:
            check_known(only, ONLY, f"{place}.only", ShellError, f"expected {' or '.join(ONLY)}")
        supports.append(Support(name, dofs, point, only))
    return supports


def fixed_components(value: Any, where: str) -> IntArray:
    """Numbers 0 ... 5 of "all", a symmetry, or a list of components. Raises ShellError."""
    names = WORDS.get(value) if isinstance(value, str) else value
    if not isinstance(names, Sequence) or isinstance(names, str) or not names:
        raise ShellError(
            f"{where} = {value!r}: expected {', '.join(WORDS)}, or a list of "
            + ", ".join(COMPONENTS)
            + did_you_mean(str(value), (*COMPONENTS, *WORDS))
        )
    for name in names:
        if name not in COMPONENTS:
            raise ShellError(
                f"{where} = {list(names)!r}: {name!r} is not one of {', '.join(COMPONENTS)}"
                + did_you_mean(str(name), COMPONENTS)
            )
    return np.unique([COMPONENTS.index(name) for name in names])


BoolArray = NDArray[np.bool_]

ALIGNED = 1e-6  # component of a unit vector that is treated as none
FLAT = np.cos(np.radians(1.0))  # of the angle between normals of cells that are treated as one


def with_straight_edges(supports: Sequence[Support], mesh: ShellMesh) -> list[Support]:
    """The supports, with rotations about the normal at nodes of edges that they keep straight.

    For flat parts with a normal along x, y or z: other rotations are not degrees of freedom.
    """
    ends, normal = _free_edges(mesh)
    axis = np.abs(normal).argmax(axis=1)
    aligned = np.abs(normal).max(axis=1) > 1.0 - ALIGNED
    ends, normal, axis = ends[aligned], normal[aligned], axis[aligned]
    if len(ends) == 0:
        return list(supports)
    along = mesh.points_G[ends[:, 1]] - mesh.points_G[ends[:, 0]]
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.cross(along, normal)
    out = []
    for support in supports:
        own = _held([support], mesh)
        purposes = ONLY if support.only is None else (support.only,)
        slides = np.zeros(len(ends), dtype=bool)
        for purpose in purposes:
            held = _held([s for s in supports if s.only in (None, purpose)], mesh)
            slides |= ~_holds(held[ends], along).all(axis=1)
        straight = _holds(own[ends], across).all(axis=1) & slides
        more = DOFS * ends[straight] + 3 + axis[straight][:, None]
        out.append(support._replace(dofs=np.union1d(support.dofs, more.ravel())))
    return out


def _holds(held: BoolArray, direction: Array) -> BoolArray:
    """Whether nodes with held components (s, 2, 3) cannot move along (s, 3): (s, 2) bool."""
    return np.asarray((held | (np.abs(direction) < ALIGNED)[:, None]).all(axis=2))


def _held(supports: Sequence[Support], mesh: ShellMesh) -> BoolArray:
    """(n, 3) bool: displacements that supports hold."""
    held = np.zeros((mesh.n_node, DOFS), dtype=bool)
    for support in supports:
        dofs = support.dofs[support.dofs < held.size]
        held.ravel()[dofs] = True
    return held[:, :3]


def _free_edges(mesh: ShellMesh) -> tuple[IntArray, Array]:
    """Sides of one cell only, (s, 2), and its normal, (s, 3), where the shell is flat at both."""
    edges = mesh.edges
    single = np.flatnonzero(edges.count[edges.number] == 1)
    normals = mesh.area_vectors_G
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    total = np.zeros((mesh.n_node, 3))
    number = np.zeros(mesh.n_node)
    for corner in mesh.cells.T:
        there = corner >= 0
        np.add.at(total, corner[there], normals[there])
        np.add.at(number, corner[there], 1.0)
    # the length of a mean of unit vectors: 1 only where all are equal
    flat = np.linalg.norm(total, axis=1) > FLAT * number
    single = single[flat[edges.ends[single]].all(axis=1)]
    return edges.ends[single], normals[edges.owner[single]]
