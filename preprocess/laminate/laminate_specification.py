"""Read a laminate from the plain data of a specification.

{"plies": [{"material": "cfrp", "angle_deg": 45.0, "thickness": 1.25e-4}, ...],  bottom to top
 "offset": "mid" | "top" | "bottom" | z of the mid-plane [m],
 "shear_correction": "energy-1d" | "5/6" | "energy-2x2" | [k1, k2]}
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ...solver.errors import check_keys, check_known, did_you_mean
from ...solver.package.body.package_schema import LaminateData
from ...solver.package.common.materials import Orthotropic
from ...solver.package.common.recovery_schema import ShellPly
from .stiffness import (
    Lamina,
    Laminate,
    LaminateError,
    LaminateStiffness,
    ShearCorrection,
    shear_factors,
    stress_operators,
)

KEYS = ("plies", "offset", "shear_correction")
PLY = ("material", "angle_deg", "thickness")
PLACES = {"mid": 0.0, "bottom": 0.5, "top": -0.5}  # offset as a fraction of the thickness


class LaminateSpec(NamedTuple):
    """A laminate with its shear correction and names."""

    laminate: Laminate
    shear: ShearCorrection
    materials: tuple[str, ...]  # name of each ply's material

    @property
    def plies(self) -> tuple[ShellPly, ...]:
        """Material, angle and faces of each ply."""
        faces = self.laminate.faces
        return tuple(
            ShellPly(material, ply.angle_deg, float(faces[k]), float(faces[k + 1]))
            for k, (material, ply) in enumerate(
                zip(self.materials, self.laminate.plies, strict=True)
            )
        )

    def data(
        self, name: str, stiffness: LaminateStiffness, constants: Mapping[str, Mapping[str, Any]]
    ) -> LaminateData:
        """The laminate in the form of a package; `constants` of all materials by name.

        Parameters
        ----------
        name : name of the laminate
        stiffness : its stiffness
        constants : constants and strengths of all materials by name
        """
        return LaminateData(
            name=name,
            plies=self.plies,
            ABD=stiffness.ABD,
            Ds=stiffness.Ds,
            stress_M=stress_operators(self.laminate),
            materials={used: dict(constants[used]) for used in dict.fromkeys(self.materials)},
        )


def laminate_from_dict(
    table: Mapping[str, Any], materials: Mapping[str, Orthotropic], where: str
) -> LaminateSpec:
    """Read a laminate; `where` is file and key of the table, for messages.

    Parameters
    ----------
    table : the laminate, as above
    materials : elastic constants by name
    where : file and key of the table, for messages

    Raises
    ------
    LaminateError : unknown key, unknown material, not a number, impossible value.
    """
    check_keys(table, KEYS, where, LaminateError)
    listed = table.get("plies")
    if not isinstance(listed, list) or not listed:
        raise LaminateError(f"{where}.plies = {listed!r}: expected a list of plies")
    plies = tuple(
        _lamina(ply, materials, f"{where}.plies[{row}]") for row, ply in enumerate(listed)
    )
    offset = _offset(table.get("offset", "mid"), plies, where)
    shear = table.get("shear_correction", "energy-1d")
    try:
        laminate = Laminate(plies, offset)
        shear_factors(laminate, shear)
    except LaminateError as error:
        raise LaminateError(f"{where}.{error}") from error
    return LaminateSpec(laminate, shear, tuple(str(ply["material"]) for ply in listed))


def _lamina(ply: Any, materials: Mapping[str, Orthotropic], where: str) -> Lamina:
    check_keys(ply, PLY, where, LaminateError)
    name = ply.get("material")
    known = f"no such material; expected one of {', '.join(materials)}"
    check_known(name, materials, f"{where}.material", LaminateError, known)
    thickness = _number(ply.get("thickness"), f"{where}.thickness", "m")
    angle_deg = _number(ply.get("angle_deg", 0.0), f"{where}.angle_deg", "deg")
    return Lamina(materials[name], angle_deg, thickness)


def _offset(value: Any, plies: tuple[Lamina, ...], where: str) -> float:
    if isinstance(value, str):
        if value not in PLACES:
            raise LaminateError(
                f'{where}.offset = "{value}": expected {", ".join(PLACES)} or a length [m]'
                + did_you_mean(value, PLACES)
            )
        return PLACES[value] * sum(ply.thickness for ply in plies)
    return _number(value, f"{where}.offset", "m")


def _number(value: Any, where: str, unit: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise LaminateError(f"{where} = {value!r}: expected a number [{unit}]")
    return float(value)
