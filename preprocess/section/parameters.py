"""Parameters of a section's description: what their change brings about at the points.

A parameter moves some numbers of the specification, its targets, each by a factor. Angles and
constants of materials leave the mesh alone. Sizes move its nodes: the mesh is made anew for
neighbouring values, with the same cells, and the velocity of a node is a difference quotient.
"""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.materials import elastic_from_dict, rotated
from ..parameters import Key, Parameter, read_parameters
from .space.cells import CellMesh, refined
from .space.layers import ALL, Layup, layup, ply_axes
from .space.mesh import SectionMesh, section_mesh
from .space.space import SectionSpace
from .spec import SectionError

Targets = Sequence[Mapping[str, Any]]  # {"of": path, "factor": number}
Marked = NDArray[np.bool_]

OPEN = (
    r"regions\.[^.]+\.plies\.\d+\.(angle_deg|thickness)",
    r"materials\.[^.]+\.(E\w*|G\w+|nu\w*|rho|C\.\d+)",
    r"mesh\.(scale|parameters\..+)",
)
MAY_BE = (
    "regions.R.plies.I.angle_deg or .thickness, materials.M.KEY (not of its strength), "
    "mesh.parameters.KEY"
)
STEP = 5e-4  # of the values, for difference quotients of fourth order
# Times this step for the mesh, whose nodes gmsh places with an error of 1e-8 of the curve: the
# first for which the mesh has the same cells.
OF_NODES = (20.0, 4.0, 1.0, 0.1)
TINY = 1e-30  # imaginary step
SMOOTH = 1e-2  # relative difference of two quotients, of first order, from nodes that jump


def parameters(
    spec: Mapping[str, Any], design: Mapping[str, Targets], where: str
) -> tuple[Parameter, ...]:
    """The parameters of a specification. Raises SectionError, see `read_parameters`."""
    return read_parameters(spec, design, OPEN, MAY_BE, _step, f"{where}.", SectionError)


def _step(spec: Mapping[str, Any], keys: tuple[Key, ...], where: str) -> float:
    value: Any = spec
    for key in keys:
        value = value[key]
    if keys[0] == "mesh" and isinstance(value, int):
        raise SectionError(f"{where} = {value!r}: expected a length, not a number of cells")
    return STEP * (60.0 if keys[-1] == "angle_deg" else abs(value) or 1.0)


def _moves(parameter: Parameter) -> bool:
    """Whether nodes may move."""
    return any(t.keys[0] == "mesh" or t.kind == "thickness" for t in parameter.targets)


class MovedMesh:
    """The mesh of a section for neighbouring values of a parameter, with the same cells.

    Parameters
    ----------
    divided : cells that were divided to refine it, step by step
    """

    def __init__(self, parameter: Parameter, mesh: SectionMesh, divided: Sequence[Marked]) -> None:
        self._parameter, self.mesh, self._divided = parameter, mesh, divided
        self._made: dict[float, SectionMesh] = {}
        step = parameter.step
        steps = next((steps for steps in OF_NODES if self._follows(steps * step)), None)
        if steps is None:
            raise parameter.refused("the mesh of a neighbouring value has other cells")
        self._steps = steps
        self.velocity = parameter.quotient(lambda t: self.at(t).cells.points, steps)
        ends = (self.at(t).cells.points for t in (-steps * step, steps * step))
        one = np.subtract(*ends) / (-2.0 * steps * step)
        size = np.abs(self.velocity).max()
        if not size > 0.0:
            raise parameter.refused("the mesh does not follow; also move the sizes of the mesh")
        if np.abs(one - self.velocity).max() > SMOOTH * size:
            raise parameter.refused("the nodes of the mesh do not follow smoothly")

    def at(self, t: float) -> SectionMesh:
        """The mesh with the parameter greater by t."""
        if t not in self._made:
            parameter = self._parameter
            mesh = section_mesh(parameter.moved(t)["mesh"], parameter.where)
            cells = mesh.cells
            for marked in self._divided:
                cells = refined(cells, marked)
            self._made[t] = replace(mesh, cells=cells)
        return self._made[t]

    def _follows(self, h: float) -> bool:
        """Whether the mesh has its cells for all changes that a quotient of step h looks at."""
        return all(_same_cells(self.at(i * h).cells, self.mesh.cells) for i in (1, -1, 2, -2))

    def turning(self, space: SectionSpace, lay: Layup) -> Array:
        """Rate of the layer direction at the points of a space, (c, q, 2)."""
        parameter = self._parameter
        here = places(space, self.mesh.cells)

        def direction(t: float) -> Array:
            mesh, other = self.at(t), copy.copy(space)
            motion = space.displacements((0, *(places(space, mesh.cells) - here).T))
            other.points = space.points + space.at_points(motion)[:, :, 1:, 0]
            found = layup(parameter.moved(t), mesh, other, parameter.where)
            if not np.array_equal(found.ply, lay.ply):
                raise parameter.refused("points change their ply: let mesh lines follow the plies")
            return found.y2

        return parameter.quotient(direction, self._steps)


def _same_cells(one: CellMesh, other: CellMesh) -> bool:
    names = ("nodes", "kind", "region", "hanging")
    return one.points.shape == other.points.shape and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in names
    )


def places(space: SectionSpace, cells: CellMesh) -> Array:
    """Positions (n_node, 2) of the nodes of a space on a mesh with its cells, also complex."""
    out = np.zeros((len(space.x2), 2), dtype=cells.points.dtype)
    shapes = {kind: (rows, s) for (kind, rows), s in zip(cells.of_kinds, cells.shapes, strict=True)}
    for part, _ in space.rules:
        rows, shape = shapes[part.kind]
        out[part.nodes] = replace(part, shape=shape[np.searchsorted(rows, part.rows)]).places()
    return out


@dataclass(frozen=True)
class Rates:
    """Derivatives by a parameter of what the solution is made of.

    Attributes
    ----------
    angle, C_M, density : of each ply, (k,) [rad], (k, 6, 6) [Pa], (k,) [kg/m3]
    y2 : (c, q, 2) of the layer direction, None if it does not change
    moved : None if the mesh does not move
    """

    parameter: Parameter
    lay: Layup
    angle: Array
    C_M: Array
    density: Array
    y2: Array | None = None
    moved: MovedMesh | None = None

    def at(self, space: SectionSpace, lay: Layup) -> "Rates":
        """The rates at the points of another rule."""
        y2 = None if self.moved is None else self.moved.turning(space, lay)
        return replace(self, lay=lay, y2=y2)

    @cached_property
    def cells(self) -> IntArray:
        """Cells whose stiffness or ply axes change."""
        if self.moved is not None:
            return np.arange(len(self.lay.ply))
        changing = (self.angle != 0.0) | np.any(self.C_M != 0.0, axis=(1, 2))
        return np.flatnonzero(np.any(changing[self.lay.ply], axis=1))

    def axes(self) -> Array:
        """A_BM + i h dA_BM in `cells`."""
        lay, cells = self.lay, self.cells
        some = np.s_[:, :1] if lay.uniform else np.s_[:, :]
        y2 = lay.y2[cells] + (0.0 if self.y2 is None else 1j * TINY * self.y2[cells])
        angle = np.radians([p.angle_deg for p in lay.plies]) + 1j * TINY * self.angle
        return ply_axes(angle[lay.ply[cells][some]], y2[some])

    def stiffness(self) -> Array:
        """C + i h dC at the points of `cells`, section axes, (s, 1 or q, 6, 6) [Pa]."""
        axes = self.axes()
        ply = self.lay.ply[self.cells][:, : axes.shape[1]]
        return rotated((self.lay.stiffness_M + 1j * TINY * self.C_M)[ply], axes)


def rates(
    parameter: Parameter,
    mesh: SectionMesh,
    space: SectionSpace,
    lay: Layup,
    divided: Sequence[Marked],
) -> Rates:
    """Derivatives of the lay-up of a section by a parameter.

    Parameters
    ----------
    divided : cells of the mesh that were divided, step by step

    Raises SectionError if the cells of the mesh cannot follow.
    """

    def angles(t: float) -> Array:
        regions, rows = parameter.moved(t)["regions"], []
        for ply in lay.plies:
            region = regions.get(ply.region) or regions[ALL]
            rows.append(np.radians(region["plies"][ply.index].get("angle_deg", 0.0)))
        return np.array(rows)

    def materials(t: float) -> Array:
        spec = parameter.moved(t)["materials"]
        known = {
            name: elastic_from_dict(table, f"{parameter.where}.materials.{name}", massless=True)
            for name, table in spec.items()
        }
        rows = {name: [own.rho, *own.stiffness_M.ravel()] for name, own in known.items()}
        return np.array([rows[ply.material] for ply in lay.plies])

    angle, constants = parameter.quotient(angles), np.zeros((len(lay.plies), 37))
    if any(t.keys[0] == "materials" for t in parameter.targets):
        constants = parameter.quotient(materials)
    fixed = Rates(parameter, lay, angle, constants[:, 1:].reshape(-1, 6, 6), constants[:, 0])
    if not _moves(parameter):
        return fixed
    if any(warning["code"] == "plies-not-resolved" for warning in lay.warnings):
        raise parameter.refused("cells contain more than one ply: let mesh lines follow the plies")
    moved = MovedMesh(parameter, mesh, divided)
    return replace(fixed, moved=moved).at(space, lay)
