"""S-N lines of the stresses that a case asks for."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..package import ModalPackage
from ..package.section.schema import Ply
from ..strength.fatigue import StressLife, check_rainflow

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import PlyStressSignal
    from ..inputs.common.materials import IsotropicMaterial, OrthotropicMaterial

    Materials = Mapping[str, IsotropicMaterial | OrthotropicMaterial]

_LINES = {"11": "fibre", "22": "transverse", "33": "transverse"}


def stress_life(
    materials: "Materials", package: ModalPackage, signal: "PlyStressSignal"
) -> StressLife | None:
    """Return the S-N line of a stress; None if the case has none for it.

    Raises
    ------
    InputError
        Cycles cannot be counted: a package is missing.
    """
    plies = [
        ply for section in package.sections if section.recovery for ply in section.recovery.plies
    ]
    named = {ply.material for ply in plies if _is_of(ply, signal)}
    for name in sorted(named & set(materials)):
        material, line = materials[name], None
        if material.kind == "isotropic":
            line = material.fatigue
        elif material.fatigue is not None:
            line = getattr(material.fatigue, _LINES.get(signal.component, "shear"))
        if line is not None:
            check_rainflow(f"materials.{name}.fatigue")
            return StressLife(
                np.array(line.amplitude),
                np.array(line.cycles),
                line.ultimate or np.inf,
                line.limit or 0.0,
            )
    return None


def _is_of(ply: Ply, signal: "PlyStressSignal") -> bool:
    return ply.index == signal.ply and signal.region in (None, ply.region)
