"""Stiffness and density of the cells of a solid, in body axes."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...solver.errors import few, nearest
from ...solver.math.arrays import Array, IntArray
from ..known_keys import check_keys
from ..materials import MaterialError, material_from_dict, rotated
from .errors import SolidError
from .mesh import SolidMesh

ALL = "all"
KEYS = ("material", "axis", "normal", "axis_about")


class CellMaterials(NamedTuple):
    """Elasticity of c cells, and the table of the material of each region."""

    C: Array  # (c, 6, 6) [Pa]
    rho: Array  # (c,) [kg/m3]
    names: tuple[str, ...]  # material of each region


def cell_materials(
    mesh: SolidMesh, regions: Mapping[str, Any], materials: Mapping[str, Any], where: str
) -> CellMaterials:
    """Materials of all cells; those of orthotropic regions have the axes at the cell's centre.

    Raises SolidError for regions without a material, unknown names, axes that are missing.
    """
    plain = mesh.plain
    unknown = [name for name in regions if name not in (*plain.regions, ALL)]
    if unknown:
        hint = nearest(unknown[0], plain.regions)
        raise SolidError(f"{where}.regions.{unknown[0]}: the solid has no such volume{hint}")
    C, rho, names = np.empty((len(plain.cells), 6, 6)), np.empty(len(plain.cells)), []
    for number, name in enumerate(plain.regions):
        region = regions.get(name, regions.get(ALL))
        if region is None:
            raise SolidError(
                f"{where}.regions.{name}: missing; the volumes are {few(plain.regions)}; expected "
                "a table for each, or for all"
            )
        key = f"{where}.regions.{name if name in regions else ALL}"
        check_keys(region, KEYS, key, SolidError)
        material = region.get("material")
        if material not in materials:
            raise SolidError(
                f"{key}.material = {material!r}: no such material"
                f"{nearest(str(material), materials)}"
            )
        table = materials[material]
        try:
            found = material_from_dict(table, f"{where}.materials.{material}")
        except MaterialError as error:
            raise SolidError(str(error)) from error
        own = np.flatnonzero(plain.region == number)
        rho[own] = found.rho
        C[own] = found.stiffness_M
        if table["kind"] == "orthotropic":
            C[own] = rotated(found.stiffness_M, _axes(mesh, region, own, key))
        names.append(material)
    return CellMaterials(C, rho, tuple(names))


def _axes(mesh: SolidMesh, region: Mapping[str, Any], own: IntArray, key: str) -> Array:
    """Axes of the material in cells, (c, 3, 3): columns 1, 2, 3."""
    if "axis_about" in region:
        if "axis" in region or "normal" in region:
            raise SolidError(f"{key}: expected axis_about alone, or axis and normal")
        about = region["axis_about"]
        along = _vector(about.get("direction"), f"{key}.axis_about.direction")
        point = np.array(about.get("point", [0.0, 0.0, 0.0]))
        arm = mesh.plain.points[mesh.plain.cells[own]].mean(axis=1) - point
        radial = arm - (arm @ along)[:, None] * along
        length = np.linalg.norm(radial, axis=1, keepdims=True)
        if not (length > 0.0).all():
            raise SolidError(f"{key}.axis_about: a cell lies on the axis; expected a hole there")
        normal = radial / length
        first = np.cross(along, normal)
    else:
        for name in ("axis", "normal"):
            if name not in region:
                raise SolidError(
                    f"{key}.{name}: missing, needed for the directions of an orthotropic material: "
                    "expected axis = [x, y, z] (1) and normal = [x, y, z] (3), or axis_about = "
                    "{point = [..], direction = [..]} (1 around, 3 outwards)"
                )
        first = _vector(region["axis"], f"{key}.axis")
        normal = _vector(region["normal"], f"{key}.normal")
        normal = normal - (normal @ first) * first
        if not np.linalg.norm(normal) > 1e-6:
            raise SolidError(f"{key}.normal: parallel to axis; expected another direction")
        first = np.tile(first, (len(own), 1))
        normal = np.tile(normal / np.linalg.norm(normal), (len(own), 1))
    return np.stack([first, np.cross(normal, first), normal], axis=2)


def _vector(value: Any, where: str) -> Array:
    found = np.array(value if isinstance(value, list) else [], dtype=float)
    if found.shape != (3,) or not np.linalg.norm(found) > 0.0:
        raise SolidError(f"{where} = {value!r}: expected a vector [x, y, z] longer than 0")
    return np.asarray(found / np.linalg.norm(found))
