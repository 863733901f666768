"""Check of the outer form of a section's specification, which may be written by hand."""

from collections.abc import Mapping
from typing import Any

from ....solver.errors import check_keys
from ..errors import SectionError

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
