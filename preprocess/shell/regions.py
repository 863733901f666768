"""Lay-up and axes of every region of a shell. A region has the cells of one physical surface."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...solver.errors import did_you_mean, few
from ...solver.math.arrays import IntArray
from ..laminate import LaminateSpec, LaminateStiffness, laminate_from_dict, laminate_stiffness
from ..materials import Orthotropic, material_from_dict
from .axes import cell_directions
from .errors import ShellError
from .mesh import ShellMesh
from .triangles import Triangles, triangles

ALL = "all"


@dataclass(frozen=True)
class Region:
    """The cells of one physical surface, their geometry and their laminate.

    `cells` (m,) are rows of the mesh's cells, `triangles` their geometry in that order; the axes
    E of a cell are those of its laminate.
    """

    name: str
    cells: IntArray
    triangles: Triangles
    laminate_name: str
    laminate: LaminateSpec
    stiffness: LaminateStiffness


def read_materials(table: Mapping[str, Any], where: str) -> dict[str, Orthotropic]:
    """Materials by name. Raises MaterialError."""
    return {name: material_from_dict(entry, f"{where}.{name}") for name, entry in table.items()}


def read_regions(spec: Mapping[str, Any], mesh: ShellMesh, where: str) -> list[Region]:
    """Every region of the mesh with the laminate that the specification gives it.

    Raises
    ------
    ShellError : a region of the mesh without laminate, a region that the mesh does not have, an
        unknown laminate, wrong axes.
        LaminateError, MaterialError : their descriptions are wrong.
    """
    materials = read_materials(spec["materials"], f"{where}.materials")
    laminates = {
        name: laminate_from_dict(table, materials, f"{where}.laminates.{name}")
        for name, table in spec.get("laminates", {}).items()
    }
    given = spec["regions"]
    for name in given:
        if name != ALL and name not in mesh.regions:
            raise ShellError(
                f"{where}.regions.{name}: the mesh has no physical surface of that name, it has "
                + few(mesh.regions)
                + did_you_mean(name, (*mesh.regions, ALL))
            )
    found = []
    for row, name in enumerate(mesh.regions):
        key = name if name in given else ALL
        if key not in given:
            raise ShellError(
                f"{where}.regions: physical surface {name!r} of the mesh has no laminate; "
                f"expected a table regions.{name}, or regions.{ALL} for all that are not named"
            )
        place = f"{where}.regions.{key}"
        laminate_name, laminate = _laminate(given[key], key, laminates, materials, place)
        cells = np.flatnonzero(mesh.region == row)
        direction = cell_directions(mesh, given[key], cells, place)
        flip = given[key].get("flip", False)
        if not isinstance(flip, bool):
            raise ShellError(f"{place}.flip = {flip!r}: expected true or false")
        try:
            geometry = triangles(mesh.points_G, mesh.cells[cells], direction, flip=flip)
        except ShellError as error:
            raise ShellError(f"{place}: {error}") from error
        stiffness = laminate_stiffness(laminate.laminate, laminate.shear)
        found.append(Region(name, cells, geometry, laminate_name, laminate, stiffness))
    return found


def _laminate(
    table: Mapping[str, Any],
    region: str,
    laminates: Mapping[str, LaminateSpec],
    materials: Mapping[str, Orthotropic],
    where: str,
) -> tuple[str, LaminateSpec]:
    if "laminate" in table:
        name = table["laminate"]
        if name not in laminates:
            raise ShellError(
                f"{where}.laminate = {name!r}: no such laminate; expected one of "
                + (few(laminates) or "those of a table laminates")
                + did_you_mean(str(name), laminates)
            )
        return str(name), laminates[name]
    if "material" not in table or "thickness" not in table:
        raise ShellError(f"{where}: expected laminate = ..., or material = ... and thickness = ...")
    plain: dict[str, Any] = {
        "plies": [{"material": table["material"], "thickness": table["thickness"]}]
    }
    for key in ("offset", "shear_correction"):
        if key in table:
            plain[key] = table[key]
    name = f"{region}: {table['material']}"
    return name, laminate_from_dict(plain, materials, where)
