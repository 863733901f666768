"""Parameters of a section's description: what their change brings about at the points.

A parameter moves some numbers of the specification, its targets, each by a factor. Angles and
constants of materials leave the mesh alone: derivatives.py. Sizes move its nodes: the mesh is made
anew for neighbouring values, with the same cells, and the velocity of a node is a difference
quotient. Derivatives are differences of analyses of meshes that move along these velocities.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.dataset import all_values
from ...solver.package.common.design import PLACES, differenced
from ...solver.package.common.materials import bond, elastic_from_dict
from ...solver.package.section.section_schema import SectionFile
from ...solver.package.specification import DesignTarget
from ..parameters import Key, Parameter, read_parameters
from .section_specification import SectionError
from .space.layers import ALL, Layup
from .space.section_cells import CellMesh, refined
from .space.section_mesh import SectionMesh, section_mesh

Targets = Sequence[DesignTarget]

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
MORPHED = 4.0  # times this step for analyses of a mesh that is moved along these velocities
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # rate of axes by an angle
TURNING = 0.5 * (bond(np.eye(3) + TURN) - bond(np.eye(3) - TURN))  # of `bond` of these axes
SMOOTH = 1e-2  # relative difference of two quotients, of first order, from nodes that jump


def parameters(
    spec: Mapping[str, Any], design: Mapping[str, Targets], where: str
) -> tuple[Parameter, ...]:
    """The parameters of a specification.

    Parameters
    ----------
    spec : description of the section, of a checked form
    design : name of each parameter -> its targets, see `read_parameters`
    where : file or section, for messages

    Raises
    ------
    SectionError
        A target that does not exist, or cannot be a parameter.
    """
    return read_parameters(spec, design, OPEN, MAY_BE, _step, f"{where}.", SectionError)


def _step(spec: Mapping[str, Any], keys: tuple[Key, ...], where: str) -> float:
    value: Any = spec
    for key in keys:
        value = value[key]
    if keys[0] == "mesh" and isinstance(value, int):
        raise SectionError(f"{where} = {value!r}: expected a length, not a number of cells")
    return STEP * (60.0 if keys[-1] == "angle_deg" else abs(value) or 1.0)


def moves(parameter: Parameter) -> bool:
    """Whether nodes may move."""
    return any(t.keys[0] == "mesh" or t.kind == "thickness" for t in parameter.targets)


@dataclass(frozen=True)
class Rates:
    """Derivatives by a parameter of what the solution is made of.

    Attributes
    ----------
    angle, C_M, density : of each ply, (k,) [rad], (k, 6, 6) [Pa], (k,) [kg/m3]
    """

    parameter: Parameter
    lay: Layup
    angle: Array
    C_M: Array
    density: Array

    @cached_property
    def cells(self) -> IntArray:
        """Cells whose stiffness or ply axes change."""
        changing = (self.angle != 0.0) | np.any(self.C_M != 0.0, axis=(1, 2))
        return np.flatnonzero(np.any(changing[self.lay.ply], axis=1))

    def stiffness(self) -> Array:
        """Rate of C at the points of `cells`, section axes, (s, 1 or q, 6, 6) [Pa]."""
        turned = TURNING @ self.lay.stiffness_M
        turned = self.angle[:, None, None] * (turned + np.swapaxes(turned, 1, 2))
        return self.lay.in_section(self.C_M + turned, self.cells)


def rates(parameter: Parameter, lay: Layup) -> Rates:
    """Derivatives of the lay-up of a section by a parameter that does not move the mesh."""

    def materials(t: float) -> Array:
        spec = parameter.moved(t)["materials"]
        known = {
            name: elastic_from_dict(table, f"{parameter.where}.materials.{name}", massless=True)
            for name, table in spec.items()
        }
        rows = {name: [own.rho, *own.stiffness_M.ravel()] for name, own in known.items()}
        return np.array([rows[ply.material] for ply in lay.plies])

    regions = parameter.spec["regions"]
    angle = np.zeros(len(lay.plies))
    for row, ply in enumerate(lay.plies):
        region = ply.region if ply.region in regions else ALL
        key = ("regions", region, "plies", ply.index, "angle_deg")
        for target in parameter.targets:
            if target.keys == key:
                angle[row] += np.radians(target.factor)
    constants = np.zeros((len(lay.plies), 37))
    if any(t.keys[0] == "materials" for t in parameter.targets):
        constants = parameter.quotient(materials)
    C_M = constants[:, 1:].reshape(-1, 6, 6)
    return Rates(parameter, lay, angle, C_M, constants[:, 0])


def by_size(
    parameter: Parameter,
    mesh: SectionMesh,
    divided: Sequence[NDArray[np.bool_]],
    analysed: Callable[[Mapping[str, Any], SectionMesh], SectionFile],
) -> dict[str, Array]:
    """Derivatives of a section, by path, by a parameter that moves the nodes of its mesh.

    Differences of analyses, of meshes whose nodes are moved along their velocities.

    Parameters
    ----------
    divided : cells of the mesh that were divided, step by step
    analysed : the section of a specification on a mesh

    Raises SectionError if the cells of the mesh cannot follow.
    """

    def made(t: float) -> SectionMesh:
        section = section_mesh(parameter.moved(t)["mesh"], parameter.where)
        for marked in divided:
            section = replace(section, cells=refined(section.cells, marked))
        return section

    for step in (steps * parameter.step for steps in OF_NODES):
        at = [made(place * step) for place in PLACES]
        if all(_same_cells(one.cells, mesh.cells) for one in at):
            break
    else:
        raise parameter.refused("the mesh of a neighbouring value has other cells")
    tables = [{"": one.cells.points, **one.curves} for one in at]
    velocity, near = differenced(tables, step), differenced(tables[1:3], step)
    if "" not in velocity:
        raise parameter.refused("the mesh does not follow; also move the sizes of the mesh")
    if np.abs(near[""] - velocity[""]).max() > SMOOTH * np.abs(velocity[""]).max():
        raise parameter.refused("the nodes of the mesh do not follow smoothly")
    section, h = [], MORPHED * parameter.step
    for t in (place * h for place in PLACES):
        cells = replace(mesh.cells, points=mesh.cells.points + t * velocity[""])
        curves = {name: c + t * velocity.get(name, 0.0) for name, c in mesh.curves.items()}
        moved = replace(mesh, cells=cells, curves=curves)
        section.append(all_values(analysed(parameter.moved(t), moved)))
    if any(not np.array_equal(one["recovery/ply"], section[0]["recovery/ply"]) for one in section):
        raise parameter.refused("points change their ply: let mesh lines follow the plies")
    rates = differenced(section, h)
    rates.pop("end_compliance", None)  # an indicator
    return rates


def _same_cells(one: CellMesh, other: CellMesh) -> bool:
    names = ("nodes", "kind", "region", "hanging")
    return one.points.shape == other.points.shape and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in names
    )
