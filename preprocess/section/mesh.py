"""Cross-section meshes: from a description to nine-node quadrilaterals by gmsh.

The mesh axes are the section's: x = x2, y = x3, origin = reference point.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...solver.errors import did_you_mean
from .. import fenicsx


class SectionError(Exception):
    """A cross-section that is described wrongly or cannot be analysed."""


@dataclass(frozen=True)
class MeshRequest:
    """A gmsh script and values for its parameters; hashable, so that meshes can be kept."""

    script: str  # name in meshes/, without .geo
    parameters: tuple[tuple[str, float], ...]


SHAPES = {"rectangle": ("width", "height"), "ellipse": ("radius_2", "radius_3")}

# Spacing of rectangles between equal (0) and cosine (1): the free edges of an off-axis laminate
# need a boundary layer of the thickness, isotropic sections lose little by it.
GRADING = 0.5


def script_path(name: str) -> Path:
    """Where the gmsh script lies: beside the package in a wheel, at the top of a checkout."""
    here = Path(__file__)
    candidates = [root.parents[2] / "meshes" / f"{name}.geo" for root in (here, here.resolve())]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise SectionError(f"gmsh script {name}.geo: not found at {candidates[0]}")


def mesh_request(spec: Mapping[str, Any], where: str) -> MeshRequest:
    """Mesh parameters of a section description.

    Parameters
    ----------
    spec : keys shape, its two sizes [m], optional `elements` (two counts: along width and height
        of a rectangle; on a quarter of the edge and from core to edge of an ellipse) and, of a
        rectangle, optional `grading` (0 to 1)
    where : file and key of the description, for messages

    Raises
    ------
    SectionError : unknown shape, size that is no positive number, bad counts.
    """
    shape = spec.get("shape")
    if shape not in SHAPES:
        raise SectionError(
            f"{where}.shape = {shape!r}: expected one of {', '.join(SHAPES)}"
            + did_you_mean(str(shape), SHAPES)
        )
    sizes = {key: _size(spec, key, where) for key in SHAPES[shape]}
    elements = _elements(spec["elements"], where) if "elements" in spec else None
    if shape == "ellipse":
        counts = elements or default_ellipse()
        values = {**sizes, "elements_arc": counts[0], "elements_radial": counts[1]}
    else:
        counts = elements or default_rectangle(sizes["width"], sizes["height"])
        grading = spec.get("grading", GRADING)
        if not _is_number(grading) or not 0.0 <= grading <= 1.0:
            raise SectionError(f"{where}.grading = {grading!r}: expected a number from 0 to 1")
        values = {
            **sizes,
            "elements_2": counts[0],
            "elements_3": counts[1],
            "grading": float(grading),
        }
    return MeshRequest(shape, tuple((key, float(value)) for key, value in values.items()))


def default_rectangle(width: float, height: float) -> tuple[int, int]:
    """Numbers of elements that keep the stiffness of an off-axis ply within about 1e-4."""
    short = 10
    slenderness = max(width, height) / min(width, height)
    long = 2 * math.ceil(short * min(slenderness, 50.0) ** 0.5 / 2)
    return (long, short) if width >= height else (short, long)


def default_ellipse() -> tuple[int, int]:
    """Numbers of elements on a quarter of the edge and from core to edge."""
    return (10, 6)


def generate(request: MeshRequest) -> fenicsx.LabelledMesh:
    """Run gmsh and convert: nine-node quadrilaterals, one physical surface "section"."""
    return fenicsx.mesh_from_geo(script_path(request.script), dict(request.parameters))


def _size(spec: Mapping[str, Any], key: str, where: str) -> float:
    value: Any = spec.get(key)
    if not _is_number(value) or not value > 0.0:
        raise SectionError(f"{where}.{key} = {value!r}: expected a length above 0 [m]")
    return float(value)


def _elements(value: Any, where: str) -> tuple[int, int]:
    good = isinstance(value, list | tuple) and len(value) == 2
    if not good or not all(type(count) is int and count >= 1 for count in value):
        raise SectionError(f"{where}.elements = {value!r}: expected two whole numbers from 1")
    return value[0], value[1]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and type(value) is not bool and math.isfinite(value)
