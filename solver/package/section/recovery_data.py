"""The recovery of a section, the same in a section file and in a package: strengths and checks."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from ...errors import did_you_mean
from ...math.arrays import Array
from ..common.array_checks import positive_definite, rotations, rows_of, symmetric
from ..common.materials import MaterialError
from ..common.remark import Reporter
from ..common.strengths import PlyStrength, YieldStrength, read_strength
from .schema import SectionRecovery

KEPT_BITS = 21  # significant bits: a relative error below 5e-7; with sign and exponent four bytes


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


class OfPlies(OfMaterials, Protocol):
    """An object with plies and their materials by name."""

    @property
    def plies(self) -> Sequence[Any]:
        """Each with the name of its `material`."""


def check_plies(owner: OfPlies, kind: str, where: str, error: Reporter) -> None:
    """Report unknown materials of plies and unusable strengths; `kind` of owner, for messages."""
    for row, ply in enumerate(owner.plies):
        if ply.material not in owner.materials:
            hint = did_you_mean(ply.material, tuple(owner.materials))
            text = f"row {row}: {ply.material!r} is not a material of the {kind}{hint}"
            error(f"{where}plies/material", text)
    check_materials(owner, where, error)


def check_materials(owner: OfMaterials, where: str, error: Reporter) -> None:
    """Report unusable strengths; `where` starts the path."""
    try:
        strengths(owner)
    except MaterialError as cause:
        error(f"{where}materials", str(cause))


def check_recovery(recovery: SectionRecovery, where: str, error: Reporter) -> None:
    """Report finite numbers of a recovery that cannot be used; `where` starts their path."""
    rows_of(f"{where}recovery/ply", recovery.ply, len(recovery.plies), error)
    rotations(f"{where}recovery/A_BM", recovery.A_BM, error)
    for row, C_M in enumerate(recovery.C_M):
        symmetric(f"{where}plies/C_M[{row}]", C_M, error)
        positive_definite(f"{where}plies/C_M[{row}]", C_M, error)
    if not np.sum(recovery.weights) > 0.0:
        text = f"expected an area above 0, found {np.sum(recovery.weights):g} m2"
        error(f"{where}recovery/weights", text)
    check_plies(recovery, "section", where, error)
