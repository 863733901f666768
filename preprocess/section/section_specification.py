"""Specification of a section, which may be written by hand: its check, what it asks for; errors."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...solver.errors import check_keys
from ...solver.math.arrays import Array

ALLOWED = ("nearly-incompressible", "ill-conditioned")  # what `allow` may list
OF_MESH = "mesh"  # degree: the functions of the nodes that each cell has, for other codes
DEGREE = 2  # of the warping field


class SectionError(Exception):
    """The description of a cross-section is wrong, or the section cannot be analysed."""


class IllConditioned(Exception):
    """The equations need other unknowns; they are not solved with these."""


REQUIRED = ("mesh", "materials", "regions")
OPTIONAL = (
    "name", "title", "convention", "allow", "initial_curvature", "taper", "not_computed"
)  # fmt: skip
REGION = ("plies", "direction")
PLY = ("material", "angle_deg", "thickness")


def check_spec(spec: Mapping[str, Any], where: str) -> None:
    """Raise SectionError for a key that is unknown, missing or not a table."""
    check_keys(spec, (*REQUIRED, *OPTIONAL), where, SectionError)
    for key in REQUIRED:
        if not isinstance(spec.get(key), Mapping) or not spec[key]:
            raise SectionError(f"{where}.{key} = {spec.get(key)!r}: expected a table")
    for name, region in spec["regions"].items():
        place = f"{where}.regions.{name}"
        if not isinstance(region, Mapping) or not isinstance(region.get("plies"), list):
            raise SectionError(f"{place} = {region!r}: expected a table with a list of plies")
        check_keys(region, REGION, place, SectionError)
        for i, ply in enumerate(region["plies"]):
            if not isinstance(ply, Mapping) or "material" not in ply:
                raise SectionError(
                    f"{place}.plies[{i}] = {ply!r}: expected a table, material = ..."
                )
            check_keys(ply, PLY, f"{place}.plies[{i}]", SectionError)


def curvature_of(spec: Mapping[str, Any]) -> Array | None:
    """Initial twist and curvature (3,) [rad/m] of a specification, None for a prismatic beam."""
    k = np.array(spec.get("initial_curvature", (0.0, 0.0, 0.0)), dtype=float)
    return k if k.any() else None


def degree_of(spec: Mapping[str, Any]) -> int | None:
    """Degree of the warping; None: the functions of the nodes of the mesh."""
    degree = spec["mesh"].get("degree", DEGREE)
    return None if degree == OF_MESH else int(degree)
