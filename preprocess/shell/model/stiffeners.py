"""Stiffeners: beams along edges of the mesh, with the nodes of the shell.

A stiffener follows a physical curve. Section axes of each edge: x1 along the curve in the
direction that gmsh gives it, x3 the shell's normal there (mean of the cells at the edge), or x2 a
given direction made normal to x1; x2 = x3 x x1. Its reference line has the distance
`offset` from the edge along x2 and x3 and is rigidly connected to the nodes: u_ref = u + theta x o.

The elements are those of beam bodies, exact under end forces for any 6x6 stiffness.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ....solver.errors import few
from ....solver.math.arrays import REGULAR, Array, IntArray, smallest_eigenvalue
from ....solver.package.common.plain_data import canonical
from ...beam.element import BeamElement
from ..cells import ShellError
from ..groups import vector
from ..mesh import ShellMesh
from .links import carried
from .regions import Region, cell_axes

KEYS = ("at", "section", "stiffness", "mass", "x2_axis", "offset")
PARALLEL = 1e-6  # sine of the angle between x2_axis and the curve


@dataclass(frozen=True)
class Stiffener:
    """A beam of `l` elements on edges of the mesh.

    Attributes
    ----------
    ends : (l, 2) nodes
    length : (l,) of the edges [m]
    A_GE : (l, 3, 3) section axes in G, v_G = A_GE v_E
    K, M : (6, 6) stiffness and mass per length of the section, section axes, order of the
        cross-sections [N, N m, N m2; kg/m, kg, kg m]
    offset : (2,) of the section's reference point along x2 and x3 [m]
    """

    name: str
    ends: IntArray
    length: Array
    A_GE: Array
    K: Array
    M: Array
    offset: Array

    def stiffness(self) -> Array:
        """Element stiffness, (l, 12, 12) in G. Paper: Eq. (35)."""
        return self._elements(lambda element: element.stiffness())

    def mass(self, form: str) -> Array:
        """Element mass, "consistent" or "lumped", (l, 12, 12) in G."""
        return self._elements(lambda element: element.mass_matrix(self.M, form))

    def geometric(self, u: Array) -> Array:
        """Geometric stiffness (l, 12, 12) in G of the axial forces of displacements u (n_dof,).

        That of a string along the reference line of the section: the work of the force N on the
        rotation of each element.
        """
        own = u.reshape(-1, 6)[self.ends].reshape(-1, 12)
        work = (self.axial_force() * own).sum(axis=1) * self.length
        turn = self.chord_rotation()
        return np.asarray(np.swapaxes(turn, 1, 2) @ (work[:, None, None] * turn))

    def axial_force(self) -> Array:
        """Axial force of each element from the motion of its ends, (l, 12) [N/m, N]."""
        return np.asarray((self.A_GE[:, None, :, 0] @ self.stiffness()[:, 6:9])[:, 0])

    def chord_rotation(self) -> Array:
        """Slope of the reference line across x1 from the motion of the ends, (l, 3, 12) in G."""
        x1 = self.A_GE[:, :, 0]
        offset = np.concatenate([[0.0], self.offset])
        moved = carried(self.A_GE @ offset)[:, :3]
        across = np.eye(3) - x1[:, :, None] * x1[:, None, :]
        change = np.concatenate([-moved, moved], axis=2) / self.length[:, None, None]
        return np.asarray(across @ change)

    def _elements(self, matrix: Callable[[BeamElement], Array]) -> Array:
        rounded = np.round(self.length / self.length.max(), 12)
        values, of = np.unique(rounded, return_inverse=True)
        in_E = np.array(
            [matrix(BeamElement(float(self.length[rounded == v].mean()), self.K)) for v in values]
        )[of]
        arm = carried(np.concatenate([[0.0], self.offset])[None])[0]
        turn = np.zeros((len(self.ends), 6, 6))
        turn[:, :3, :3] = turn[:, 3:, 3:] = np.swapaxes(self.A_GE, 1, 2)
        both = np.zeros((len(self.ends), 12, 12))
        both[:, :6, :6] = both[:, 6:, 6:] = arm @ turn
        out = np.swapaxes(both, 1, 2) @ in_E @ both
        return np.asarray(0.5 * (out + np.swapaxes(out, 1, 2)))


def read_stiffeners(
    table: Mapping[str, Any], mesh: ShellMesh, regions: Sequence[Region], where: str
) -> list[Stiffener]:
    """The stiffeners of a specification: {name: {at, section or stiffness and mass, ...}}.

    Raises
    ------
    ShellError : no such curve, no section or a wrong one, an axis along the curve.
    SectionError, MaterialError : the description of the section is wrong.
    """
    found = []
    for name, entry in table.items():
        place = f"{where}.{name}"
        at = str(entry.get("at"))
        if at not in mesh.curves:
            raise ShellError(
                f"{place}.at = {at!r}: expected a physical curve of the mesh, it has "
                + (few(mesh.curves) or "none")
            )
        ends = np.asarray(mesh.curves[at])
        along = np.diff(mesh.points_G[ends], axis=1)[:, 0]
        length = np.linalg.norm(along, axis=1)
        x1 = along / length[:, None]
        K, M = _section(entry, place)
        A_GE = _axes(entry.get("x2_axis"), x1, ends, mesh, regions, place)
        offset = np.asarray(entry.get("offset", (0.0, 0.0)), dtype=float)
        if offset.shape != (2,) or not np.isfinite(offset).all():
            raise ShellError(
                f"{place}.offset = {entry['offset']!r}: expected two lengths, along x2 and x3"
            )
        found.append(Stiffener(name, ends, length, A_GE, K, M, offset))
    return found


def _axes(
    given: Any,
    x1: Array,
    ends: IntArray,
    mesh: ShellMesh,
    regions: Sequence[Region],
    where: str,
) -> Array:
    """Section axes of each edge, (l, 3, 3)."""
    if given is None:
        normals = cell_axes(mesh, regions)[mesh.edges.owner, :, 2]
        found = np.concatenate([mesh.edges.sums(normals), np.zeros((1, 3))])[mesh.edges.find(ends)]
        x3 = _crossed(x1, np.cross(found, x1))
        x2 = np.cross(x3, x1)
    else:
        x2 = np.broadcast_to(vector(given, f"{where}.x2_axis"), x1.shape)
        x2 = x2 - np.einsum("li,li->l", x2, x1)[:, None] * x1
        size = np.linalg.norm(x2, axis=1)
        if not (size > PARALLEL * np.linalg.norm(given)).all():
            raise ShellError(f"{where}.x2_axis = {given!r}: expected a direction across the curve")
        x2 = x2 / size[:, None]
    return np.stack([x1, x2, np.cross(x1, x2)], axis=2)


def _crossed(x1: Array, x2: Array) -> Array:
    """Unit x3 = x1 x x2, (l, 3)."""
    x3 = np.cross(x1, x2)
    return np.asarray(x3 / np.linalg.norm(x3, axis=1)[:, None])


def _section(entry: Mapping[str, Any], where: str) -> tuple[Array, Array]:
    """Stiffness and mass of the section, each (6, 6)."""
    if ("section" in entry) == ("stiffness" in entry) or ("stiffness" in entry) != (
        "mass" in entry
    ):
        raise ShellError(f"{where}: expected `section`, or `stiffness` with `mass`")
    if "section" in entry:
        found = _analysed(canonical(entry["section"]), f"{where}.section")
        return found.K, found.M
    matrices = []
    for key, least in (("stiffness", REGULAR), ("mass", -1e-12)):
        A = np.asarray(entry[key], dtype=float)
        if A.shape != (6, 6) or not np.allclose(A, A.T, rtol=1e-9, atol=1e-12 * np.abs(A).max()):
            raise ShellError(f"{where}.{key}: expected a symmetric matrix of 6 rows")
        if not smallest_eigenvalue(A) > least:
            kind = "definite" if key == "stiffness" else "semi-definite"
            raise ShellError(f"{where}.{key}: expected a positive {kind} matrix")
        matrices.append(A)
    return matrices[0], matrices[1]


@lru_cache(maxsize=64)
def _analysed(text: str, where: str) -> Any:
    """Analyse a section once and reuse the result for other stiffeners."""
    from ...section.analysis import analyse  # here: few shells have stiffeners

    return analyse(json.loads(text), where=where, estimate=False)
