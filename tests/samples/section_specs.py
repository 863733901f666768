"""Specifications of plain sections, as the light side makes them of a description."""

from typing import Any

from plymotion.solver.inputs.section.shapes.library import expand, walls


def rectangle_spec(
    width: float, height: float, material: dict[str, Any], ply_angle_deg: float = 0.0
) -> dict[str, Any]:
    """A rectangle [m] of one material, its plies normal to x3."""
    ply = {"material": "m", "angle_deg": ply_angle_deg}
    return {
        "name": "rectangle",
        "convention": "contour",
        "mesh": expand("rectangle", {"width": width, "height": height}),
        "materials": {"m": material},
        "regions": {"section": {"plies": [ply], "direction": {"vector": [1.0, 0.0]}}},
    }


def library_spec(name: str, sizes: dict[str, float], material: dict[str, Any]) -> dict[str, Any]:
    """A section of the library, of one material."""
    ply = {"material": "m", "angle_deg": 0.0}
    return {
        "name": name,
        "convention": "contour",
        "mesh": expand(name, sizes),
        "materials": {"m": material},
        "regions": {
            wall.region: {"plies": [ply], "direction": dict(wall.direction)}
            for wall in walls(name, sizes)
        },
    }
