"""The cross-sections of tests/reference/sections on library meshes of any density."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from plymotion.solver.inputs.section.shapes.library import expand, walls

FOLDER = Path(__file__).resolve().parents[1] / "reference" / "sections"


@cache
def reference(name: str) -> dict[str, Any]:
    """The reference file whose name begins so."""
    (path,) = FOLDER.glob(f"{name}*.toml")
    return tomllib.loads(path.read_text(encoding="utf-8"))


def section(
    name: str,
    density: float = 1.0,
    *,
    degree: int = 2,
    sizes: dict[str, float] | None = None,
    angles: dict[str, list[float]] | None = None,
) -> dict[str, Any]:
    """Specification of a reference section.

    Parameters
    ----------
    name : beginning of the file's name
    density : of the elements along every line, over the default
    degree : of the warping field
    sizes : further sizes of the shape, such as a number of elements
    angles : other ply angles [deg] than the reference's, wall by wall
    """
    table = reference(name)
    shape, values = _shape(table["geometry"])
    values |= {"density": density} | (sizes or {})
    listed = table["material"]
    tables = listed if isinstance(listed, list) else [listed]
    materials = {f"material-{i}": _material(entry) for i, entry in enumerate(tables)}
    layup = table.get("layup", {})
    regions = {}
    for i, wall in enumerate(walls(shape, values)):
        stack = (angles or layup).get(wall.region, [layup.get("theta3", 0.0)])
        material = f"material-{min(i, len(tables) - 1)}"
        plies = [{"material": material, "angle_deg": angle} for angle in stack]
        regions[wall.region] = {"plies": plies, "direction": dict(wall.direction)}
    layers = {region: [1.0] * len(wall["plies"]) for region, wall in regions.items()}
    return {
        "name": table["id"],
        "convention": "contour",
        "mesh": {**expand(shape, values, layers), "degree": degree},
        "materials": materials,
        "regions": regions,
    }


def _shape(geometry: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Shape of the library and its sizes."""
    kind = geometry["type"]
    if kind == "rectangle":
        sizes = {"width": geometry["b"], "height": geometry["h"]}
        if "interface_x2" in geometry:
            return "split-rectangle", {**sizes, "interface": geometry["interface_x2"]}
        return "rectangle", sizes
    if kind == "ellipse":
        return "ellipse", {"radius_2": geometry["a2"], "radius_3": geometry["a3"]}
    if kind in ("tube", "half tube"):
        sizes = {key: geometry[key] for key in ("outer_radius", "wall")}
        if "span_deg" in geometry:
            start, end = geometry["span_deg"]
            sizes |= {"start_deg": start, "span_deg": end - start}
        return "tube", sizes
    if kind.startswith("rectangular box"):
        sizes = {"width": geometry["outer_b"], "height": geometry["outer_h"]}
        return "box", {**sizes, "wall": geometry["wall"]}
    if kind.startswith("channel, sharp corners"):
        return "channel", {
            "height": geometry["web_height"],
            "top_width": geometry["top_flange"],
            "bottom_width": geometry["bottom_flange"],
            "wall": geometry["wall"],
        }
    if kind == "I":
        return "i", {
            "height": geometry["height"],
            "top_width": geometry["flange_width"],
            "wall": geometry["flange"],
            "wall_web": geometry["web"],
        }
    raise ValueError(f"geometry of type {kind!r}")


def _material(table: dict[str, Any]) -> dict[str, Any]:
    if "E" in table:
        return {"kind": "isotropic", **{key: table[key] for key in ("E", "nu", "rho")}}
    numbers = {key: value for key, value in table.items() if key not in ("name", "where")}
    return {"kind": "orthotropic", **numbers}
