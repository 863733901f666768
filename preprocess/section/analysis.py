"""From the description of a cross-section to its stiffness and mass."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...solver.errors import did_you_mean
from ...solver.package.schema import Array
from ..materials import material_from_dict, ply_rotation, rotated
from .forms import section_space
from .inertia import mass_centre, mass_matrix
from .mesh import SHAPES, SectionError, mesh_request
from .timoshenko import shear_centre, stiffness, tension_centre

_KEYS = ("name", "shape", "elements", "grading", "material", "ply_angle_deg")


@dataclass(frozen=True)
class SectionResult:
    """What a beam needs to know of its cross-section; origin and axes are the section's."""

    K: Array  # (6, 6) stiffness: extension, shear2, shear3, twist, bend2, bend3
    M: Array  # (6, 6) mass per length for [v1, v2, v3, w1, w2, w3]
    shear_centre: Array  # (2,) x2, x3 [m]
    tension_centre: Array  # (2,) [m]
    mass_centre: Array  # (2,) [m]
    n_dof: int
    seconds: dict[str, float]  # by phase: mesh_and_forms, assembly, stiffness, mass, total


def analyse(spec: Mapping[str, Any], where: str | None = None) -> SectionResult:
    """Stiffness and mass of a cross-section of one material.

    Parameters
    ----------
    spec : plain data,
        {"name": "arm", "shape": "rectangle", "width": 0.06, "height": 0.015,
        "elements": [16, 8], "material": {"kind": "orthotropic", ...}, "ply_angle_deg": 30.0}
        or shape "ellipse" with "radius_2" and "radius_3"; width and radius_2 lie along x2.
        `elements`, `grading` (rectangle) and `ply_angle_deg` may be left out. The plies lie
        normal to x3; the fibre points along cos(angle) x1 + sin(angle) x2.
    where : file and key of the description for messages, the section's name by default

    Raises
    ------
    SectionError, MaterialError : a wrong description (file or section, key, value, expectation).
    FactorisationError, MeshError : no result from FEniCSx or gmsh.
    """
    start = time.perf_counter()
    where = where or f"section {spec.get('name', '')}".strip()
    _check_keys(spec, where)
    if "material" not in spec:
        raise SectionError(f"{where}.material: missing, expected a table of constants")
    material = material_from_dict(spec["material"], f"{where}.material")
    angle = spec.get("ply_angle_deg", 0.0)
    if type(angle) not in (int, float) or not np.isfinite(angle):
        raise SectionError(f"{where}.ply_angle_deg = {angle!r}: expected an angle [deg]")

    seconds = {}
    space = section_space(mesh_request(spec, where))
    seconds["mesh_and_forms"] = time.perf_counter() - start

    lap = time.perf_counter()
    C_B = rotated(material.stiffness_M, ply_rotation(angle))
    matrices = space.matrices(np.broadcast_to(C_B, (space.n_cell, 6, 6)))
    seconds["assembly"] = time.perf_counter() - lap

    lap = time.perf_counter()
    K = stiffness(space, matrices).K
    seconds["stiffness"] = time.perf_counter() - lap

    lap = time.perf_counter()
    M = mass_matrix(space, np.full(space.n_cell, material.rho))
    seconds["mass"] = time.perf_counter() - lap
    seconds["total"] = time.perf_counter() - start
    return SectionResult(
        K, M, shear_centre(K), tension_centre(K), mass_centre(M), space.n_dof, seconds
    )


def _check_keys(spec: Mapping[str, Any], where: str) -> None:
    known = [*_KEYS, *SHAPES.get(str(spec.get("shape")), ())]
    if spec.get("shape") == "ellipse":
        known.remove("grading")
    for key in spec:
        if key not in known and spec.get("shape") in SHAPES:
            raise SectionError(
                f"{where}.{key}: unknown key of a {spec['shape']}; expected {', '.join(known)}"
                + did_you_mean(str(key), known)
            )
