"""Supports: fixed degrees of freedom of groups."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...solver.errors import did_you_mean
from ...solver.math.arrays import Array, IntArray
from .assembly import DOFS
from .errors import ShellError
from .groups import united
from .links import Link
from .mesh import ShellMesh

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
    """The supports of a specification: {name: {at, fixed, only}}; `at` is a group, several of
    one kind, or a link.

    Raises ShellError for an unknown group or component, and for a support on the reference point of
    an average link.
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
        if only is not None and only not in ONLY:
            raise ShellError(
                f"{place}.only = {only!r}: expected {' or '.join(ONLY)}"
                + did_you_mean(str(only), ONLY)
            )
        supports.append(Support(name, dofs, point, only))
    return supports


def fixed_components(value: Any, where: str) -> IntArray:
    """Numbers 0 ... 5 of "all", a symmetry, or a list of components. Raises ShellError."""
    names = WORDS.get(value) if isinstance(value, str) else value
    known = (*COMPONENTS, *WORDS)
    if not isinstance(names, Sequence) or isinstance(names, str) or not names:
        raise ShellError(
            f"{where} = {value!r}: expected {', '.join(WORDS)}, or a list of "
            + ", ".join(COMPONENTS)
            + did_you_mean(str(value), known)
        )
    for name in names:
        if name not in COMPONENTS:
            raise ShellError(
                f"{where} = {list(names)!r}: {name!r} is not one of {', '.join(COMPONENTS)}"
                + did_you_mean(str(name), COMPONENTS)
            )
    return np.unique([COMPONENTS.index(name) for name in names])
