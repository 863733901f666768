"""Plies, and data for their stresses: what the files of sections, shells and bodies share.

A body loads these classes alone: each dataclass takes time of every run's start.
Resultants of a section, stresses and sizes as in section/section_schema.py.
"""

from dataclasses import dataclass
from typing import Annotated

from ...math.arrays import Array, IntArray
from ...math.records import record
from .dataset import Data, Rows

RESULTANTS = ("F1", "F2", "F3", "M1", "M2", "M3")
STRESSES = ("11", "22", "33", "23", "13", "12")
CORNERS = {5: 3, 22: 3, 9: 4, 23: 4, 28: 4}  # of the VTK cell types of a section
LEVELS = ("bottom", "middle", "top")  # of a ply


@dataclass(frozen=True)
class Ply:
    """One ply of a region, or a region of one material."""

    region: Annotated[str, Data(text="region that the ply belongs to")]
    index: Annotated[int, Data(text="place in the stack of its region, 0 is outermost")]
    material: Annotated[str, Data(text="name of the ply's material")]
    angle_deg: Annotated[float, Data("", "deg", "layer", "fibre angle from x1 towards y2")]


@record
class SectionRecovery:
    """Data for strains and stresses of every integration point from the six resultants.

    strain_M[p] @ F6 is the strain of point p in the axes of its ply; C_M[ply[p]] times it is the
    stress.
    """

    weights: Annotated[Array, Data("p", "m2", "-", "area of each point", "recovery/weights")]
    points: Annotated[
        Array,
        Data("p, 2", "m", "section", "x2 and x3 of the integration points", "recovery/points"),
    ]
    cell: Annotated[
        IntArray, Data("p", "-", "-", "cell of each point, as row of cell_types", "recovery/cell")
    ]
    ply: Annotated[
        IntArray, Data("p", "-", "-", "ply of each point, as row of plies", "recovery/ply")
    ]
    A_BM: Annotated[
        Array,
        Data("p, 3, 3", "-", "ply to section", "rotation, ply to section axes", "recovery/A_BM"),
    ]
    strain_M: Annotated[
        Array,
        Data("p, 6, 6", "1/N, 1/(N m)", "ply", "strain per unit resultant", "recovery/strain_M"),
    ]
    C_M: Annotated[
        Array, Data("k, 6, 6", "Pa", "ply", "stiffness of the ply's material", "plies/C_M")
    ]
    plies: Annotated[tuple[Ply, ...], Rows("plies", "k")]
    materials: Annotated[
        dict[str, dict[str, object]], Data(text="constants and strengths by name, as JSON text")
    ]


@dataclass(frozen=True)
class ShellPly:
    """One ply of a laminate."""

    material: Annotated[str, Data(text="name of the ply's material")]
    angle_deg: Annotated[float, Data("", "deg", "E", "fibre angle from e1 towards e2")]
    bottom: Annotated[float, Data("", "m", "E", "height of the lower face along e3")]
    top: Annotated[float, Data("", "m", "E", "height of the upper face along e3")]
