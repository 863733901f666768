"""The recovery of a section as datasets, the same in a section file and in a package."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from ...math.arrays import Array
from ..common.dataset import DatasetSpec, F, I, T, spec
from ..common.identity import json_table, json_text
from ..common.materials import MaterialError
from ..common.strengths import PlyStrength, YieldStrength, read_strength
from .schema import Ply, SectionRecovery

RECOVERY_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("plies/region", "k", T, "-", "-", "region that the ply belongs to"),
    spec("plies/index", "k", I, "-", "-", "place in the stack of its region, 0 is outermost"),
    spec("plies/material", "k", T, "-", "-", "name of the ply's material"),
    spec("plies/angle_deg", "k", F, "deg", "layer", "fibre angle from x1 towards y2"),
    spec("plies/C_M", "k, 6, 6", F, "Pa", "ply", "stiffness of the ply's material"),
    spec("materials", "", T, "-", "-", "constants and strengths by name, as JSON text"),
    spec("recovery/points", "p, 2", F, "m", "section", "x2 and x3 of the integration points"),
    spec("recovery/weights", "p", F, "m2", "-", "area of each point"),
    spec("recovery/cell", "p", I, "-", "-", "cell of each point, as row of cell_types"),
    spec("recovery/ply", "p", I, "-", "-", "ply of each point, as row of plies"),
    spec("recovery/A_BM", "p, 3, 3", F, "-", "ply to section", "rotation, ply to section axes"),
    spec("recovery/strain_M", "p, 6, 6", F, "1/N, 1/(N m)", "ply", "strain per unit resultant"),
)
RECOVERY_SIZED_BY = {"k": "plies/region", "p": "recovery/weights"}

POINT_DATA = ("points", "weights", "cell", "ply", "A_BM", "strain_M")
_PLY_COLUMNS = ("region", "index", "material", "angle_deg")

KEPT_BITS = 21  # significant bits: a relative error below 5e-7; with sign and exponent four bytes


def recovery_values(recovery: SectionRecovery, where: str) -> dict[str, Any]:
    """Return the value of every dataset of RECOVERY_LAYOUT by path.

    `where` names file and group for PackageError, raised for materials that JSON cannot hold.
    """
    plies = recovery.plies
    values: dict[str, Any] = {
        "plies/region": [ply.region for ply in plies],
        "plies/index": np.array([ply.index for ply in plies], dtype=np.int64),
        "plies/material": [ply.material for ply in plies],
        "plies/angle_deg": np.array([ply.angle_deg for ply in plies], dtype=float),
        "plies/C_M": recovery.C_M,
        "materials": json_text(f"{where}/materials", recovery.materials),
    }
    return values | {f"recovery/{name}": getattr(recovery, name) for name in POINT_DATA}


def recovery_sizes(values: Mapping[str, Any]) -> dict[str, int]:
    """Return the sizes that the arrays of a recovery declare."""
    return {symbol: len(values[path]) for symbol, path in RECOVERY_SIZED_BY.items()}


def recovery_from(data: Mapping[str, Any], where: str) -> SectionRecovery:
    """Put the values of RECOVERY_LAYOUT together. Raises PackageError for damaged materials."""
    rows = zip(*(data[f"plies/{column}"] for column in _PLY_COLUMNS), strict=True)
    return SectionRecovery(
        C_M=data["plies/C_M"],
        plies=tuple(
            Ply(region, int(index), material, float(angle))
            for region, index, material, angle in rows
        ),
        materials=json_table(f"{where}/materials", data["materials"]),
        **{name: data[f"recovery/{name}"] for name in POINT_DATA},
    )


def thinned(recovery: SectionRecovery) -> SectionRecovery:
    """The same recovery with strains rounded to a relative 5e-7, compressed to half the size."""
    return replace(recovery, strain_M=rounded(recovery.strain_M))


def rounded(values: Array) -> Array:
    """Numbers with their last bits set to zero: a relative error below 5e-7."""
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.round(np.ldexp(mantissa, KEPT_BITS)), exponent - KEPT_BITS))


class OfMaterials(Protocol):
    """An object with constants and strengths of materials by name."""

    @property
    def materials(self) -> dict[str, dict[str, Any]]:
        """Tables of materials by name."""


def strengths(recovery: OfMaterials) -> dict[str, PlyStrength | YieldStrength]:
    """Strengths of the materials that have any, by name. Raises MaterialError."""
    found = {}
    for name, material in recovery.materials.items():
        if not isinstance(material, Mapping):
            raise MaterialError(f"{name}: expected a table of constants, got {material!r}")
        table = material.get("strength")
        if table is not None:
            found[name] = read_strength(table, str(material.get("kind")), f"{name}.strength")
    return found
