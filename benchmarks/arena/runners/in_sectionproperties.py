"""sectionproperties: torsion and bending of isotropic sections with six-node triangles."""

from pathlib import Path
from typing import Any

from common import Sheet, Timed, main

NAME = "sectionproperties"
ENVIRONMENT: dict[str, Any] = {"pip": ["sectionproperties==3.10.2", "numpy"]}
SHAPES = {"rectangle", "tube", "i"}


def cannot(sheet: Sheet) -> str:
    """Isotropic sections of a few shapes."""
    if sheet["kind"] != "section":
        return "a section code"
    import description

    table = description.read_toml(sheet)
    if any(m["kind"] != "isotropic" for m in table["materials"].values()):
        return "isotropic materials only"
    if table["mesh"].get("shape") not in SHAPES:
        return f"no shape {table['mesh'].get('shape')} in this runner"
    return "" if set(sheet["values"]) <= {"EA", "GJ", "EI2", "EI3"} else "no full stiffness matrix"


def settings(sheet: Sheet) -> list[Sheet]:
    """Triangles."""
    return [{"method": "T6", "cells": n} for n in (200, 800, 3200, 12800)]


def outline(m: Sheet) -> Any:
    """Polygon of a description's shape."""
    from shapely import Point, box

    if m["shape"] == "rectangle":
        return box(-m["width"] / 2, -m["height"] / 2, m["width"] / 2, m["height"] / 2)
    if m["shape"] == "tube":
        circle = Point(0, 0).buffer(m["outer_radius"], quad_segs=256)
        return circle - Point(0, 0).buffer(m["outer_radius"] - m["wall"], quad_segs=256)
    h, b, tw, tf = m["height"] / 2, m["top_width"] / 2, m["wall_web"] / 2, m["wall_top"]
    flanges = box(-b, h - tf, b, h).union(box(-b, -h, b, -h + tf))
    return flanges.union(box(-tw, -h, tw, h))


def solve(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Mesh, warping, constants."""
    import tomllib

    from sectionproperties.analysis import Section
    from sectionproperties.pre import Geometry, Material

    table = tomllib.loads(Path(sheet["file"]).read_text(encoding="utf-8"))
    (m,) = table["materials"].values()
    polygon = outline(table["mesh"])
    geometry = Geometry(polygon, Material("m", m["E"], m["nu"], 1.0, m["rho"], "grey"))
    with Timed() as used:
        geometry.create_mesh(mesh_sizes=[1.6 * polygon.area / setting["cells"]])
        section = Section(geometry)
        section.calculate_geometric_properties()
        section.calculate_warping_properties()
        eixx, eiyy, _ = section.get_eic()
    G = m["E"] / (2.0 * (1.0 + m["nu"]))
    found = {"EI2": eixx, "EI3": eiyy, "GJ": section.get_ej() / m["E"] * G, "EA": section.get_ea()}
    return {name: float(found[name]) for name in sheet["values"]}, used.seconds


if __name__ == "__main__":
    main(solve)
