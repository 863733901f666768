"""A section whose file gives mesh, materials and orientation of every cell, as VABS and BECAS do.

Angles are ours and VABS's: theta1 turns x2 to the layer direction y2, theta3 turns the fibre from
x1 towards y2.
"""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import InputError
from ....math.arrays import Array, IntArray
from ....package.common.anisotropic import elastic_from_dict
from ....package.common.materials import MaterialError
from ..foreign import write_npz

TRIANGLE, QUADRILATERAL = 0, 1
ABSENT = -1
MOST_NODES = 9


Constants = dict[str, float | str | list[float]]  # of a material


@dataclass(frozen=True)
class CellSection:
    """Mesh and orientation; `n` counts nodes, `c` cells.

    Attributes
    ----------
    points : (n, 2) [m]
    nodes : (c, 9) rows of points: corners, middles of the edges from that of the first two corners,
        centre; ABSENT where there is none
    kind : (c,) TRIANGLE or QUADRILATERAL
    theta1 : (c, 1) or (c, 9) angle of the layer direction, for the cell or at its nodes [deg]
    ply : (c,) row of plies
    plies : material and theta3 [deg] of each
    materials : constants by name, as in a description
    curvature : (3,) initial twist and curvature [rad/m]
    not_computed : models that the file asks for and that are not computed
    places : file, and line or row, of each material, for messages
    """

    file: Path
    points: Array
    nodes: IntArray
    kind: IntArray
    theta1: Array
    ply: IntArray
    plies: list[tuple[str, float]]
    materials: dict[str, Constants]
    curvature: tuple[float, float, float] = (0.0, 0.0, 0.0)
    title: str = ""
    not_computed: list[str] = field(default_factory=list)
    places: dict[str, str] = field(default_factory=dict)


def cell_section_spec(section: CellSection, folder: Path) -> dict[str, Any]:
    """Return the specification of a section; its arrays are written to a folder.

    The warping has the functions of the nodes of the file's cells, so that the result can be
    compared digit by digit.

    Raises
    ------
    InputError
        Cells without a ply, nodes that do not exist, impossible constants of a material in use.
        A ply without cells is left out.
    """
    if section.nodes.max() >= len(section.points):
        raise InputError(f"{section.file}: a cell has a node that does not exist")
    used = np.unique(section.ply)
    names = [f"ply-{row + 1}" for row in used]
    arrays, digest = write_npz(
        folder,
        section.file.stem,
        points=section.points,
        cells=section.nodes,
        kind=section.kind,
        layer_angle=section.theta1,
        cell_type=np.array("mixed"),
        region=np.searchsorted(used, section.ply),
        region_names=np.array(names, dtype=str),
    )
    regions = {}
    for name, row in zip(names, used, strict=True):
        material, angle = section.plies[row]
        regions[name] = {
            "plies": [{"material": material, "angle_deg": angle}],
            "direction": {"cells": True},
        }
    used_materials = {section.plies[row][0] for row in used}
    for name in sorted(used_materials):  # others may have any numbers
        try:
            elastic_from_dict(section.materials[name], section.places[name], massless=True)
        except MaterialError as error:
            raise InputError(str(error)) from error
    spec: dict[str, Any] = {
        "name": section.file.stem,
        "title": section.title or section.file.name,
        "convention": "contour",
        "mesh": {"arrays": os.path.relpath(arrays), "sha256": digest, "degree": "mesh"},
        "materials": {n: m for n, m in section.materials.items() if n in used_materials},
        "regions": regions,
    }
    if any(section.curvature):
        spec["initial_curvature"] = list(section.curvature)
    if section.not_computed:
        spec["not_computed"] = section.not_computed
    return spec
