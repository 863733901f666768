"""Laminates of a shell body and the resultants of its cells: in memory, and as datasets.

`_E` are the axes of a cell and of its laminate: e3 the normal, e1 the reference direction of the
plies projected on the cell. Resultants of a cell, for unit width: N11 N22 N12 [N/m], M11 M22 M12
[N], T1 T2 [N/m].
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray
from ..common.dataset import DatasetSpec, F, I, T, spec
from ..common.identity import json_table, json_text
from ..shell.schema import ShellPly


@dataclass(frozen=True)
class LaminateData:
    """A laminate of the body; `k` counts its plies."""

    name: str
    plies: tuple[ShellPly, ...]  # bottom to top along e3
    ABD: Array  # (6, 6) of (N, M) to (e, kappa)            [N/m, N, N m]
    Ds: Array  # (2, 2) transverse shear, corrected         [N/m]
    stress_M: Array  # (k, 3, 6, 8) stress 11 22 33 23 13 12 in ply axes per unit resultant,
    # at bottom, middle and top of each ply                 [1/m, 1/m2]
    materials: dict[str, dict[str, Any]]  # constants and strengths as described, by name


@dataclass(frozen=True)
class CellResultants:
    """Mean resultants of `e` cells: resultants_E[j] @ q are those of cell `cell[j]`."""

    cell: IntArray  # (e,) row of the package's cells
    laminate: IntArray  # (e,) row of the package's laminates
    A_BE: Array  # (e, 3, 3) axes of cell and laminate in body axes [-]
    resultants_E: Array  # (e, 8, m) per unit mode          [N/m, N]


LAMINATE_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("plies/material", "k", T, "-", "-", "name of the ply's material"),
    spec("plies/angle_deg", "k", F, "deg", "E", "fibre angle from e1 towards e2"),
    spec("plies/bottom", "k", F, "m", "E", "height of the lower face along e3"),
    spec("plies/top", "k", F, "m", "E", "height of the upper face along e3"),
    spec(
        "plies/stress_M",
        "k, 3, 6, 8",
        F,
        "1/m, 1/m2",
        "ply",
        "stress at bottom, middle, top per unit resultant",
    ),
    spec("ABD", "6, 6", F, "N/m, N, N m", "E", "N and M per unit strain and curvature"),
    spec("Ds", "2, 2", F, "N/m", "E", "transverse shear stiffness, corrected"),
    spec("materials", "", T, "-", "-", "constants and strengths by name, as JSON text"),
)
LAMINATE_SIZED_BY = {"k": "plies/material"}

# All datasets of the group `cell_resultants`, or none.
CELL_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("cell_resultants/cell", "e", I, "-", "-", "cells, as rows of cell_types"),
    spec("cell_resultants/laminate", "e", I, "-", "-", "laminate of each cell, by its index"),
    spec("cell_resultants/A_BE", "e, 3, 3", F, "-", "E to B", "rotation, axes of the cell to B"),
    spec(
        "cell_resultants/resultants_E",
        "e, 8, m",
        F,
        "N/m, N",
        "E",
        "N 3, M 3, T 2, mean of the cell, per unit mode",
    ),
)
CELL_SIZED_BY = {"e": "cell_resultants/cell"}


def laminate_values(laminate: LaminateData, where: str) -> dict[str, Any]:
    """Return the value of every dataset of LAMINATE_LAYOUT by path.

    `where` names file and group for PackageError, raised for materials that JSON cannot hold.
    """
    values: dict[str, Any] = {
        "plies/material": [ply.material for ply in laminate.plies],
        "plies/stress_M": laminate.stress_M,
        "ABD": laminate.ABD,
        "Ds": laminate.Ds,
        "materials": json_text(f"{where}/materials", laminate.materials),
    }
    for name in ("angle_deg", "bottom", "top"):
        values[f"plies/{name}"] = np.array([getattr(p, name) for p in laminate.plies], dtype=float)
    return values


def laminate_from(name: str, data: Mapping[str, Any], where: str) -> LaminateData:
    """Build the laminates from the values of LAMINATE_LAYOUT. Raises PackageError for damaged
    materials."""
    columns = (data[f"plies/{column}"] for column in ("material", "angle_deg", "bottom", "top"))
    return LaminateData(
        name=name,
        plies=tuple(
            ShellPly(material, float(angle), float(bottom), float(top))
            for material, angle, bottom, top in zip(*columns, strict=True)
        ),
        ABD=data["ABD"],
        Ds=data["Ds"],
        stress_M=data["plies/stress_M"],
        materials=json_table(f"{where}/materials", data["materials"]),
    )
