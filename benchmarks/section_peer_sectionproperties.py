"""Run by section_peers.py in an environment with sectionproperties; prints JSON.

Geometry is that of tests/reference/sections. Shear areas of sectionproperties are Pilkey's, for
the Poisson's ratio of the material, about the principal axes.
"""

import json
import statistics
import time
import tomllib
from importlib.metadata import version
from pathlib import Path

from sectionproperties.analysis import Section
from sectionproperties.pre import Geometry, Material
from shapely import Point, Polygon, box

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "reference" / "sections"
REPEATS = 3
CELLS = 1500  # about, of six-node triangles


def read(name):
    (path,) = FOLDER.glob(f"{name}*.toml")
    return tomllib.loads(path.read_text(encoding="utf-8"))


def outline(g):
    """The polygon of a reference's geometry."""
    if g["type"] == "rectangle":
        return box(-g["b"] / 2, -g["h"] / 2, g["b"] / 2, g["h"] / 2)
    if g["type"] == "tube":
        circle = Point(0, 0).buffer(g["outer_radius"], quad_segs=64)
        return circle - Point(0, 0).buffer(g["outer_radius"] - g["wall"], quad_segs=64)
    if g["type"] == "I":
        h, b, tw, tf = g["height"] / 2, g["flange_width"] / 2, g["web"] / 2, g["flange"]
        return box(-b, h - tf, b, h).union(box(-tw, -h, tw, h)).union(box(-b, -h, b, -h + tf))
    h, t = g["web_height"] / 2, g["wall"]
    web = box(0, -h, t, h)
    top, bottom = box(0, h - t, g["top_flange"], h), box(0, -h, g["bottom_flange"], -h + t)
    return Polygon(web.union(top).union(bottom).exterior)


def solved(name):
    reference = read(name)
    m = reference["material"]
    material = Material("m", m["E"], m["nu"], 1.0, m["rho"], "grey")
    polygon = outline(reference["geometry"])
    geometry = Geometry(polygon, material)
    geometry.create_mesh(mesh_sizes=[1.6 * polygon.area / CELLS])
    seconds = []
    for _ in range(REPEATS):
        section = Section(geometry)
        start = time.process_time()
        section.calculate_geometric_properties()
        section.calculate_warping_properties()
        seconds.append(time.process_time() - start)
    shear = section.get_eas(e_ref=m["E"])
    return {
        "J": float(section.get_ej()) / m["E"],
        "shear": [float(a) / polygon.area for a in shear],
        "shear_centre": [float(x) for x in section.get_sc()],
        "unknowns": int(section.num_nodes),
        "seconds": statistics.median(seconds),
    }


found = {"version": version("sectionproperties"), "sections": {}}
for number in ("02", "06", "11", "12"):
    found["sections"][number] = solved(number)
print(json.dumps(found))
