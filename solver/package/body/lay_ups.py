"""Modal stiffness of a shell body with other lay-ups of its laminates, from its package alone.

The stiffness of a ply is affine in t = (cos 2a, sin 2a, cos 4a, sin 4a) of its angle a, so A, B and
D are affine in twelve lamination parameters (Tsai and Hahn 1980). The stiffness of triangles
without transverse shear is linear in A, B and D. In the modes of a package, whose laminates have
its derivatives by their entries,

    K(plies) = K + sum over entries of (A, B, D of the plies - A, B, D) dK/d(entry)

is therefore exact: Phi' K Phi of the shell with these plies, in the modes of the package.
"""

from collections.abc import Sequence

import numpy as np

from ...errors import PackageError
from ...math.arrays import Array
from ..common.materials import material_from_dict
from ..shell.plies import PATTERNS, harmonics, moments, ply_factors
from .package_schema import ModalPackage

ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # of A, then B, then D
ROWS, COLUMNS = np.array(ENTRIES).T
Plies = Sequence[float] | Array


class LayUp:
    """A laminate of a package with other angles and thicknesses of its plies.

    Parameters
    ----------
    package : of a shell
    laminate : its name; None for the only one

    Attributes
    ----------
    angles_deg, thicknesses : those of the package, (k,) [deg], [m]

    Raises
    ------
    PackageError : no such laminate, or one without derivatives of the stiffness.
    """

    def __init__(self, package: ModalPackage, laminate: str | None = None) -> None:
        known = {each.name: each for each in package.laminates}
        own = known.get(next(iter(known), "") if laminate is None else laminate)
        if own is None or (laminate is None and len(known) > 1):
            names = ", ".join(known) or "none"
            raise PackageError(f"{package.body}: laminate {laminate!r}: expected one of {names}")
        if own.stiffness_rates is None:
            why = package.provenance.get("no_stiffness_rates", "a body without [design] parameters")
            raise PackageError(
                f"{package.body}: laminate {own.name}: no `stiffness_rates` in the package: {why}; "
                "expected a shell of triangles with elements.plate = dkt and [design] parameters"
            )
        self._K, self._rates, plies = package.stiffness, own.stiffness_rates, own.plies
        self.angles_deg = np.array([ply.angle_deg for ply in plies])
        z = np.array([plies[0].bottom, *(ply.top for ply in plies)])
        self.thicknesses, self._middle = np.diff(z), 0.5 * (z[0] + z[-1])
        materials = {n: material_from_dict(table, n) for n, table in own.materials.items()}
        self._mean, self._factors = ply_factors([materials[ply.material] for ply in plies])
        self._own = self._entries(self.angles_deg, self.thicknesses)

    def stiffness(self, angles_deg: Plies, thicknesses: Plies | None = None) -> Array:
        """Modal stiffness (..., m, m) [N m].

        Parameters
        ----------
        angles_deg : of the plies from bottom to top, of one lay-up or many, (..., k)
        thicknesses : (k,) [m]; None for those of the package. The mid-plane of the laminate stays
            where it is. The modal mass is that of the package.

        Raises
        ------
        PackageError : another number of plies.
        """
        angles = np.asarray(angles_deg, dtype=float)
        thick = self.thicknesses if thicknesses is None else np.asarray(thicknesses, dtype=float)
        if (*angles.shape[-1:], *thick.shape) != 2 * self.angles_deg.shape:
            raise PackageError(f"lay-up: expected numbers of {len(self.angles_deg)} plies")
        change = self._entries(angles, thick) - self._own
        return np.asarray(self._K + np.tensordot(change, self._rates, 1))

    def _entries(self, angles_deg: Array, thicknesses: Array) -> Array:
        """Entries of A, B and D, (..., 18)."""
        H = moments(thicknesses, self._middle)
        p = H @ (self._factors * harmonics(angles_deg))
        ABD = np.tensordot(H, self._mean, 1) + np.tensordot(p, PATTERNS, 1)
        return ABD[..., ROWS, COLUMNS].reshape(*angles_deg.shape[:-1], 18)
