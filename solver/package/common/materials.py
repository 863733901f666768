"""Materials: elastic constants, their bounds, stiffness and its rotation; strengths.

Stress and strain are columns in the paper's order 11, 22, 33, 23, 13, 12 with
engineering shear strains (2 eps_23, 2 eps_13, 2 eps_12). `_M` are the axes of
the material (1 along the fibre, 3 normal to the ply), `_B` those of the member.

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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ...errors import did_you_mean
from ...math.arrays import REGULAR, Array
from ...math.records import record

_UNITS = {"E": "Pa", "G": "Pa", "n": "-", "r": "kg/m3"}  # by first letter of the key


class MaterialError(Exception):
    """Material constants are missing, unknown or physically impossible."""


@dataclass(frozen=True)
class Orthotropic:
    """An orthotropic material by its nine engineering constants.

    `nu12` is the contraction along 2 under tension along 1: eps_22 = -nu12 eps_11. Moduli in Pa,
    density in kg/m3, also 0. Raises MaterialError if no elastic material can have these constants.
    """

    E1: float
    E2: float
    E3: float
    G12: float
    G13: float
    G23: float
    nu12: float
    nu13: float
    nu23: float
    rho: float

    def __post_init__(self) -> None:
        check(self, "material")

    @property
    def compliance_M(self) -> Array:
        """Compliance: strain_M = compliance_M @ stress_M, (6, 6) [1/Pa]."""
        S = np.diag(1.0 / np.array([self.E1, self.E2, self.E3, self.G23, self.G13, self.G12]))
        S[0, 1] = S[1, 0] = -self.nu12 / self.E1
        S[0, 2] = S[2, 0] = -self.nu13 / self.E1
        S[1, 2] = S[2, 1] = -self.nu23 / self.E2
        return S

    @property
    def stiffness_M(self) -> Array:
        """Stiffness in the material's own axes, (6, 6) [Pa].

        Paper: Eq. (17), with the engineering shear strains of (18): as printed, (17) lacks their
        factor 2.
        """
        C = np.linalg.inv(self.compliance_M)
        return 0.5 * (C + C.T)


def isotropic(E: float, nu: float, rho: float) -> Orthotropic:
    """The isotropic material of modulus E [Pa], Poisson's ratio nu and density rho [kg/m3].

    Parameters
    ----------
    E : Young's modulus [Pa]
    nu : Poisson's ratio
    rho : density [kg/m3]
    """
    _check_isotropic(E, nu, "material")
    G = E / (2.0 * (1.0 + nu))
    return Orthotropic(E, E, E, G, G, G, nu, nu, nu, rho)


def material_from_dict(
    table: Mapping[str, Any], where: str, *, massless: bool = False
) -> Orthotropic:
    """Material of a table {"kind": "isotropic" | "orthotropic", constants}.

    Parameters
    ----------
    table : E, nu, rho of an isotropic material, or the nine constants and rho of an orthotropic
        one; "name" and "strength" (`read_strength`) are allowed and ignored
    where : file and key of the table, for messages
    massless : the density may be 0

    Raises
    ------
    MaterialError : unknown or missing key, not a number, impossible constants.
    """
    if not isinstance(table, Mapping):
        raise MaterialError(f"{where}: expected a table of constants, got {table!r}")
    kinds = {
        "isotropic": ("E", "nu", "rho"),
        "orthotropic": tuple(field.name for field in fields(Orthotropic)),
    }
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in kinds:
        raise MaterialError(
            f"{where}.kind = {kind!r}: expected one of {', '.join(kinds)}"
            + did_you_mean(str(kind), kinds)
        )
    keys = kinds[kind]
    for key in table:
        if key not in (*keys, "kind", "name", "strength"):
            raise MaterialError(
                f"{where}.{key}: unknown key of an {kind} material; expected "
                + ", ".join(keys)
                + did_you_mean(str(key), keys)
            )
    values = {key: _number(table, key, where) for key in keys}
    if kind == "isotropic":
        _check_isotropic(values["E"], values["nu"], where)
        check_density(values["rho"], where, massless)
        return isotropic(**values)
    _check(values, where, massless)
    return Orthotropic(**values)


def bond(A_BM: Array) -> Array:
    """Matrix T that rotates stress columns: stress_B = T stress_M (Bond 1943).

    Parameters
    ----------
    A_BM : (..., 3, 3) rotations, v_B = A_BM v_M

    Returns
    -------
    (..., 6, 6); T' rotates engineering strains in the opposite direction, strain_M = T' strain_B
    """
    A_BM = np.asarray(A_BM)
    pairs = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    T = np.empty((*A_BM.shape[:-2], 6, 6), dtype=np.result_type(A_BM, float))
    for row, (i, j) in enumerate(pairs):
        for column, (k, m) in enumerate(pairs):
            T[..., row, column] = A_BM[..., i, k] * A_BM[..., j, m]
            if k != m:  # a shear stress represents two entries of the tensor
                T[..., row, column] += A_BM[..., i, m] * A_BM[..., j, k]
    return T


def check(material: Orthotropic, where: str) -> None:
    """Raise MaterialError unless the constants are positive, but the density may be 0, and the
    compliance is definite."""
    values = {field.name: float(getattr(material, field.name)) for field in fields(material)}
    _check(values, where, massless=True)


def _check(c: Mapping[str, float], where: str, massless: bool) -> None:
    for key, value in c.items():
        if key[0] in "EG":
            _check_positive(key, value, where)
    check_density(c["rho"], where, massless)
    for a, b in ("12", "13", "23"):
        nu, ratio = c[f"nu{a}{b}"], c[f"E{a}"] / c[f"E{b}"]
        if not nu * nu < ratio:  # a power overflows with an error
            raise MaterialError(
                f"{where}.nu{a}{b} = {nu:g}: expected nu{a}{b}^2 < E{a}/E{b} = {ratio:g}, "
                f"that is |nu{a}{b}| < {math.sqrt(ratio):.6g}"
            )
    nu21 = c["nu12"] * c["E2"] / c["E1"]
    nu31 = c["nu13"] * c["E3"] / c["E1"]
    nu32 = c["nu23"] * c["E3"] / c["E2"]
    determinant = (
        1 - c["nu12"] * nu21 - c["nu13"] * nu31 - c["nu23"] * nu32 - 2 * nu21 * nu32 * c["nu13"]
    )
    if not determinant > REGULAR:
        raise MaterialError(
            f"{where}: nu12 = {c['nu12']:g}, nu13 = {c['nu13']:g} and nu23 = {c['nu23']:g} "
            "together are too large: "
            "expected 1 - nu12 nu21 - nu13 nu31 - nu23 nu32 - 2 nu21 nu32 nu13 > 0, "
            f"got {determinant:.6g}"
        )


def _check_isotropic(E: float, nu: float, where: str) -> None:
    _check_positive("E", E, where)
    if not -1.0 < nu < 0.5:
        raise MaterialError(f"{where}.nu = {nu:g}: expected -1 < nu < 0.5")


def _check_positive(key: str, value: float, where: str) -> None:
    if not (value > 0.0 and math.isfinite(value)):
        raise MaterialError(f"{where}.{key} = {value:g} {_UNITS[key[0]]}: expected a value above 0")


def check_density(rho: float, where: str, massless: bool) -> None:
    """Raise MaterialError for a density [kg/m3] that is not above 0, or 0 if `massless`.

    Parameters
    ----------
    rho : density [kg/m3]
    where : path of the material, for messages
    massless : 0 is allowed
    """
    if massless and not rho >= 0.0:
        raise MaterialError(f"{where}.rho = {rho:g} kg/m3: expected 0 or more")
    if not massless:
        _check_positive("rho", rho, where)


def _number(table: Mapping[str, Any], key: str, where: str) -> float:
    if key not in table:
        raise MaterialError(f"{where}.{key}: missing, expected a number [{_UNITS[key[0]]}]")
    return finite_number(table[key], f"{where}.{key}", _UNITS[key[0]])


def finite_number(value: Any, where: str, unit: str) -> float:
    """Return a number; raise MaterialError for anything else.

    Parameters
    ----------
    value : value of the input
    where : its path, for messages
    unit : its unit, for messages
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise MaterialError(f"{where} = {value!r}: expected a number [{unit}]")
    return float(value)


def ply_rotation(ply_angle_deg: float) -> Array:
    """Axes of a ply in those of its wall: A_BM (3, 3), v_B = A_BM v_M.

    The fibre direction is cos(angle) e1 + sin(angle) e2, right-handed about the outward
    normal e3 of the wall.
    """
    angle = math.radians(ply_angle_deg)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def rotated(C_M: Array, A_BM: Array) -> Array:
    """Stiffness in the axes of the member: C_B = T C_M T', (..., 6, 6) [Pa].

    Paper: Eq. (18), Eq. (19).

    Parameters
    ----------
    C_M : (..., 6, 6) stiffness in material axes [Pa]
    A_BM : (..., 3, 3) rotation, v_B = A_BM v_M
    """
    T = bond(A_BM)
    C = T @ C_M @ np.swapaxes(T, -1, -2)
    return np.asarray(0.5 * (C + np.swapaxes(C, -1, -2)))


UPPER = np.triu_indices(6)
KEYS = ("kind", "C", "rho", "name")


@record
class Anisotropic:
    """A material by its stiffness.

    Attributes
    ----------
    stiffness_M : (6, 6) in the material's own axes, order 11, 22, 33, 23, 13, 12 with engineering
        shear strains [Pa]
    rho : density [kg/m3]
    """

    stiffness_M: Array
    rho: float

    @property
    def compliance_M(self) -> Array:
        """Compliance: strain_M = compliance_M @ stress_M, (6, 6) [1/Pa]."""
        return np.asarray(np.linalg.inv(self.stiffness_M), dtype=float)


def elastic_from_dict(
    table: Mapping[str, Any], where: str, *, massless: bool = False
) -> Orthotropic | Anisotropic:
    """Material of a table; beside the kinds of `material_from_dict`, one with 21 constants.

    Parameters
    ----------
    table : {"kind": "anisotropic", "C": 21 numbers, "rho": number}, C the upper triangle of the
        stiffness row by row [Pa]; or any other table
    where : file and key of the table, for messages
    massless : the density may be 0

    Raises
    ------
    MaterialError : unknown or missing key, no number, a stiffness that is not positive definite.
    """
    if not isinstance(table, Mapping) or table.get("kind") != "anisotropic":
        return material_from_dict(table, where, massless=massless)
    for key in table:
        if key not in KEYS:
            raise MaterialError(f"{where}.{key}: unknown key; expected {', '.join(KEYS)}")
    numbers = table.get("C")
    if not isinstance(numbers, list) or len(numbers) != len(UPPER[0]):
        raise MaterialError(f"{where}.C: expected {len(UPPER[0])} numbers [Pa]")
    values = [*numbers, table.get("rho")]
    if not all(isinstance(v, int | float) and math.isfinite(v) for v in values):
        raise MaterialError(f"{where}: expected finite numbers C [Pa] and rho [kg/m3]")
    rho = float(values[-1])
    check_density(rho, where, massless)
    C = of_upper(numbers)
    lowest = float(np.linalg.eigvalsh(C)[0])
    if not lowest > 0.0:
        raise MaterialError(
            f"{where}.C: expected a positive definite stiffness, its least eigenvalue is "
            f"{lowest:.3g} Pa"
        )
    return Anisotropic(C, rho)


def of_upper(numbers: Sequence[float]) -> Array:
    """Return the symmetric matrix (6, 6) of the 21 numbers of its upper triangle, row by row."""
    C = np.zeros((6, 6))
    C[UPPER] = numbers
    return np.asarray(C + np.triu(C, 1).T)


CRUSHING_ANGLE = math.radians(53.0)
S23_PER_YC = math.cos(CRUSHING_ANGLE) * (
    math.sin(CRUSHING_ANGLE) + math.cos(CRUSHING_ANGLE) / math.tan(2 * CRUSHING_ANGLE)
)
F12_STAR = -0.5

_REQUIRED = {"orthotropic": ("Xt", "Xc", "Yt", "Yc", "S12"), "isotropic": ("yield_stress",)}
_OPTIONAL = {"orthotropic": ("Zt", "Zc", "S13", "S23", "F12_star"), "isotropic": ()}


@record
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
    values = {key: _strength(value, key, where) for key, value in table.items()}
    if kind == "isotropic":
        return YieldStrength(**values)
    defaults = {
        "Zt": values["Yt"],
        "Zc": values["Yc"],
        "S13": values["S12"],
        "S23": S23_PER_YC * values["Yc"],
    }
    return PlyStrength(**{**defaults, **values})


def _strength(entry: Any, key: str, where: str) -> float:
    share = key == "F12_star"
    value = finite_number(entry, f"{where}.{key}", "-" if share else "Pa")
    if share and not -0.5 <= value < 1.0:
        raise MaterialError(
            f"{where}.{key} = {value:g}: expected -0.5 <= F12_star < 1: outside, the failure "
            "surface is not closed in three dimensions"
        )
    if not share and not value > 0.0:
        raise MaterialError(f"{where}.{key} = {value:g} Pa: expected a value above 0")
    return value
