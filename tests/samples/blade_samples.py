"""A windIO file of a small blade: a round root, an airfoil, spar caps, a sandwich and two webs."""

import csv
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import yaml


def along(*values: float) -> dict[str, Any]:
    return {"grid": np.linspace(0.0, 1.0, len(values)).tolist(), "values": list(values)}


def anchor(name: str, start: float, end: float) -> dict[str, Any]:
    both = {"start_nd_arc": along(start, start), "end_nd_arc": along(end, end)}
    return {"name": name, **both}


def layer(name: str, material: str, thickness: float, **keys: Any) -> dict[str, Any]:
    at = keys.pop("at", name)
    ends = {
        f"{end}_nd_arc": {"anchor": {"name": at, "handle": f"{end}_nd_arc"}}
        for end in ("start", "end")
    }
    table = {"name": name, "material": material, "thickness": along(thickness, thickness)}
    return {**table, "fiber_orientation": along(0.0, 0.0), **ends, **keys}


def symmetric(thickness: float) -> dict[str, list[float]]:
    """A symmetric airfoil of four digits, closed, from the trailing edge over the suction side."""
    x = 0.5 * (1.0 + np.cos(np.linspace(0.0, np.pi, 60)))
    y = 5.0 * thickness * (0.2969 * np.sqrt(x) + x * (-0.126 + x * (-0.3516 + x * (0.2843))))
    y -= 5.0 * thickness * 0.1036 * x**4
    return {"x": [*x.tolist(), *x[-2::-1].tolist()], "y": [*y.tolist(), *(-y[-2::-1]).tolist()]}


def circle() -> dict[str, list[float]]:
    angle = np.linspace(0.0, 2.0 * np.pi, 101)
    return {"x": (0.5 + 0.5 * np.cos(angle)).tolist(), "y": (0.5 * np.sin(angle)).tolist()}


def blade_table() -> dict[str, Any]:
    glass = {"E": [45e9, 12e9, 12e9], "G": [5e9, 5e9, 4e9], "nu": [0.3, 0.3, 0.4]}
    materials: list[dict[str, Any]] = [
        {"name": "glass", "orth": 1, "rho": 1900.0, **glass},
        {"name": "foam", "orth": 0, "rho": 100.0, "E": 130e6, "nu": 0.3},
        {"name": "adhesive", "orth": 0, "rho": 1100.0, "E": 4e9, "nu": 0.35},
    ]
    anchors = [
        anchor("shell", 0.0, 1.0),
        anchor("cap-s", 0.28, 0.36),
        anchor("cap-p", 0.64, 0.72),
        anchor("core-s", 0.05, 0.28),
        anchor("web", 0.32, 0.68),
    ]
    ends = {
        f"{end}_nd_arc": {"anchor": {"name": "web", "handle": f"{end}_nd_arc"}}
        for end in ("start", "end")
    }
    layers = [
        layer("skin", "glass", 0.004, at="shell"),
        layer("cap-s", "glass", 0.02),
        layer("cap-p", "glass", 0.02),
        layer("core-s", "foam", 0.015),
        layer("inner", "glass", 0.002, at="shell"),
        layer("web-skin", "glass", 0.003, at="web", web="web"),
        layer("web-core", "foam", 0.012, at="web", web="web"),
    ]
    airfoils = [
        {"name": "round", "rthick": 1.0, "coordinates": circle()},
        {"name": "thin", "rthick": 0.24, "coordinates": symmetric(0.24)},
    ]
    shape = {
        "chord": along(2.0, 2.0, 1.0),
        "twist": along(10.0, 0.0),
        "section_offset_y": along(1.0, 0.6, 0.3),
        "rthick": {"grid": [0.0, 0.1, 0.5, 1.0], "values": [1.0, 1.0, 0.24, 0.24]},
        "airfoils": [{"name": "round"}, {"name": "thin"}],
    }
    structure = {"webs": [{"name": "web", "anchors": [], **ends}], "layers": layers}
    blade = {
        "reference_axis": {"z": along(0.0, 20.0)},
        "outer_shape": shape,
        "structure": {**structure, "anchors": anchors},
    }
    return {"components": {"blade": blade}, "airfoils": airfoils, "materials": materials}


def write_blade(folder: Path, table: dict[str, Any] | None = None) -> Path:
    file = folder / "small.yaml"
    # libyaml takes a tenth of the time of Python.
    text = yaml.dump(table or blade_table(), Dumper=yaml.CSafeDumper)
    file.write_text(text, encoding="utf-8")
    return file


def area(points: np.ndarray) -> float:
    """Area of a polygon (n, 2), negative if it is clockwise."""
    x, y = points, np.roll(points, -1, axis=0)
    return 0.5 * float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum())


def areas(mesh: Any) -> Counter[str]:
    """Area of each region of the mesh of a station [m2]."""
    nodes, found = np.array(mesh.nodes), Counter[str]()
    for cell, region in zip(mesh.cells, mesh.regions, strict=True):
        found[region] += area(nodes[list(cell)])
    return found


def rows_of(file: Path) -> list[dict[str, str]]:
    """Rows of a table with commas; lines with # are comments."""
    with file.open(newline="") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))
