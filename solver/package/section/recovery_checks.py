"""Checks of the stress recovery data of a section."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from ...errors import did_you_mean
from ..common.array_checks import finite, positive_definite, rotations, rows_of, symmetric
from ..common.materials import MaterialError
from ..common.remark import Reporter
from .recovery_data import POINT_DATA, OfMaterials, strengths
from .schema import SectionRecovery


def check_recovery(recovery: SectionRecovery, where: str, error: Reporter) -> None:
    """Report numbers of a recovery that cannot be used; `where` starts the path of its datasets."""
    arrays = {f"{where}recovery/{name}": getattr(recovery, name) for name in POINT_DATA}
    arrays[f"{where}plies/C_M"] = recovery.C_M
    for path, values in arrays.items():
        finite(path, values, error)
    if not all(np.isfinite(values).all() for values in arrays.values()):
        return
    rows_of(f"{where}recovery/ply", recovery.ply, len(recovery.plies), error)
    rotations(f"{where}recovery/A_BM", recovery.A_BM, error)
    for row, C_M in enumerate(recovery.C_M):
        symmetric(f"{where}plies/C_M[{row}]", C_M, error)
        positive_definite(f"{where}plies/C_M[{row}]", C_M, error)
    if not np.sum(recovery.weights) > 0.0:
        text = f"expected an area above 0, found {np.sum(recovery.weights):g} m2"
        error(f"{where}recovery/weights", text)
    check_plies(recovery, "section", where, error)


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
    try:
        strengths(owner)
    except MaterialError as cause:
        error(f"{where}materials", str(cause))
