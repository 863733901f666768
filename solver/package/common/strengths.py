"""Strengths of a material: keys, units, and reasons for the defaults.

    [materials.cfrp.strength]
    Xt, Xc     along the fibre, in tension and compression          [Pa]
    Yt, Yc     across the fibre in the ply                          [Pa]
    S12        shear in the ply                                     [Pa]
    Zt, Zc     normal to the ply; default Yt, Yc: a unidirectional ply is isotropic in 2 and 3
    S13        default S12, for the same reason
    S23        default Yc cos(a) (sin(a) + cos(a) / tan(2 a)) = 0.377 Yc with a = 53 deg, the
               fracture plane of unidirectional plies under transverse compression (Puck and
               Schuermann 1998; Davila, Camanho and Rose 2005): S23 is hard to measure
    F12_star   interaction of normal stresses in Tsai-Wu, default -0.5: Mises' for Xt = Xc

    [materials.steel.strength]
    yield_stress                                                    [Pa]

All strengths are magnitudes.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import did_you_mean
from .materials import MaterialError, finite_number

CRUSHING_ANGLE = math.radians(53.0)
S23_PER_YC = math.cos(CRUSHING_ANGLE) * (
    math.sin(CRUSHING_ANGLE) + math.cos(CRUSHING_ANGLE) / math.tan(2 * CRUSHING_ANGLE)
)
F12_STAR = -0.5

_REQUIRED = {"orthotropic": ("Xt", "Xc", "Yt", "Yc", "S12"), "isotropic": ("yield_stress",)}
_OPTIONAL = {"orthotropic": ("Zt", "Zc", "S13", "S23", "F12_star"), "isotropic": ()}


@dataclass(frozen=True)
class PlyStrength:
    """Magnitude of each uniaxial stress at failure of a ply [Pa]; t tension, c compression.

    `F12_star` [-] is F_ij / sqrt(F_ii F_jj) of Tsai-Wu for the three pairs of normal stresses.
    """

    Xt: float
    Xc: float
    Yt: float
    Yc: float
    Zt: float
    Zc: float
    S12: float
    S13: float
    S23: float
    F12_star: float = F12_STAR


@dataclass(frozen=True)
class YieldStrength:
    """The yield stress of an isotropic material [Pa]."""

    yield_stress: float


def read_strength(table: Mapping[str, Any], kind: str, where: str) -> PlyStrength | YieldStrength:
    """Strengths of a material from its table, with defaults.

    Parameters
    ----------
    table : keys as in the text at the top of this file
    kind : kind of the material, "orthotropic" or "isotropic"
    where : file and key of the table, for messages

    Raises
    ------
    MaterialError : unknown or missing key, not a positive number, F12_star without a
        closed failure surface.
    """
    if not isinstance(table, Mapping):
        raise MaterialError(f"{where}: expected a table of strengths, got {table!r}")
    if kind not in _REQUIRED:
        raise MaterialError(f"{where}: a material of kind {kind!r} has no strengths")
    known = _REQUIRED[kind] + _OPTIONAL[kind]
    for key in table:
        if key not in known:
            raise MaterialError(
                f"{where}.{key}: unknown strength of an {kind} material; expected "
                + ", ".join(known)
                + did_you_mean(str(key), known)
            )
    for key in _REQUIRED[kind]:
        if key not in table:
            raise MaterialError(f"{where}.{key}: missing, expected a stress [Pa]")
    values = {key: _number(value, key, where) for key, value in table.items()}
    if kind == "isotropic":
        return YieldStrength(**values)
    defaults = {
        "Zt": values["Yt"],
        "Zc": values["Yc"],
        "S13": values["S12"],
        "S23": S23_PER_YC * values["Yc"],
    }
    return PlyStrength(**{**defaults, **values})


def _number(found: Any, key: str, where: str) -> float:
    share = key == "F12_star"
    value = finite_number(found, f"{where}.{key}", "-" if share else "Pa")
    if share and not -0.5 <= value < 1.0:
        raise MaterialError(
            f"{where}.{key} = {value:g}: expected -0.5 <= F12_star < 1: outside, the failure "
            "surface is not closed in three dimensions"
        )
    if not share and not value > 0.0:
        raise MaterialError(f"{where}.{key} = {value:g} Pa: expected a value above 0")
    return value
