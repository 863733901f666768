"""Fully anisotropic elastic materials, in files of other codes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...math.arrays import Array
from .materials import MaterialError, Orthotropic, check_density, material_from_dict

UPPER = np.triu_indices(6)
KEYS = ("kind", "C", "rho", "name")


@dataclass(frozen=True, eq=False)
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
