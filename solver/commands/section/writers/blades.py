"""Blade files from the 6x6 of stations: BeamDyn's blade file and HAWC2's st file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ....errors import InputError, printable
from ....math.arrays import Array
from ..conventions import BLADE_AXES_TRAILING_EDGE, Axes, convert, transform
from .text import written

UPPER = np.triu_indices(6)


def write_beamdyn(
    file: Path,
    places: Sequence[float],
    stiffness: Sequence[Array],
    mass: Sequence[Array],
    *,
    title: str,
    damping: Sequence[float] = (0.0,) * 6,
    blade_axes: Axes = BLADE_AXES_TRAILING_EDGE,
) -> Path:
    """Write a blade file of BeamDyn (OpenFAST); returns the file.

    Parameters
    ----------
    places : positions of the stations along the blade, ascending; they are divided by the last one
    stiffness, mass : (6, 6) of each station in our order, about BeamDyn's reference axis
    damping : stiffness-proportional coefficients mu of the six directions [s]
    blade_axes : see `convert`

    Raises
    ------
    InputError
        Fewer than two stations, positions that do not ascend, other numbers of matrices.
    """
    x = _stations(places, stiffness, mass)
    eta = (x - x[0]) / (x[-1] - x[0])
    lines = [
        " ------- BEAMDYN V1.00.* INDIVIDUAL BLADE INPUT FILE --------------------------",
        f" {printable(title)}",
        " ---------------------- BLADE PARAMETERS --------------------------------------",
        f"{len(x):6d}   station_total    - Number of blade input stations (-)",
        f"{int(any(damping)):6d}   damp_type        - Damping type: 0: no damping; 1: damped",
        " ---------------------- DAMPING COEFFICIENT------------------------------------",
        "   mu1        mu2        mu3        mu4        mu5        mu6",
        "   (-)        (-)        (-)        (-)        (-)        (-)",
        " " + " ".join(f"{value:.6E}" for value in damping),
        " ---------------------- DISTRIBUTED PROPERTIES---------------------------------",
    ]
    for place, K, M in zip(eta, stiffness, mass, strict=True):
        lines.append(f"  {place:.12f}")
        for matrix, kind in ((K, "stiffness"), (M, "mass")):
            for row in convert(matrix, "beamdyn", kind, blade_axes=blade_axes):
                lines.append("  " + "  ".join(f"{value: .15E}" for value in row))
            lines.append("")
    return written(file, lines)


def write_hawc2(
    file: Path,
    places: Sequence[float],
    stiffness: Sequence[Array],
    mass: Sequence[Array],
    *,
    title: str,
) -> Path:
    """Write an st file of HAWC2 with fully populated stiffness (FPM); returns the file.

    Each row has r, m, x_cg, y_cg, ri_x, ri_y, pitch, x_e, y_e and the upper triangle of the
    stiffness about the elastic centre in the order of BECAS (shear x, shear y, axial, bending x,
    bending y, torsion). x and y are x2 and x3, z is x1; pitch is 0. The radii of gyration are about
    the elastic centre; the format has no product of inertia.

    Parameters
    ----------
    places : arc length of the stations along the half-chord line, ascending [m]
    stiffness, mass : (6, 6) of each station in our order, about the half-chord line
    """
    x = _stations(places, stiffness, mass)
    names = ["r", "m", "x_cg", "y_cg", "ri_x", "ri_y", "pitch", "x_e", "y_e"]
    names += [f"K_{i + 1}{j + 1}" for i, j in zip(*UPPER, strict=True)]
    rows = []
    for r, K, M in zip(x - x[0], stiffness, mass, strict=True):
        centre = _elastic_centre(K)
        m = M[0, 0]
        at_centre = transform(M, centre, kind="mass")
        radii = np.sqrt(np.diag(at_centre)[4:] / m)
        moved = convert(transform(K, centre), "becas")
        values = [r, m, -M[0, 5] / m, M[0, 4] / m, *radii, 0.0, *centre, *moved[UPPER]]
        rows.append(" ".join(f"{value: .15e}" for value in values))
    lines = [
        "1 number of sets, Nset",
        f"#1 {printable(title)}",
        " ".join(f"{n:>22s}" for n in names),
    ]
    return written(file, [*lines, f"$1 {len(rows)}", *rows])


def _elastic_centre(K: Array) -> Array:
    """(x2, x3) where an axial force does not bend the beam [m]."""
    S = np.linalg.inv(K)
    M2, M3 = np.linalg.solve(S[4:, 4:], -S[4:, 0])
    return np.array([-M3, M2])


def _stations(places: Sequence[float], stiffness: Sequence[Array], mass: Sequence[Array]) -> Array:
    x = np.asarray(places, dtype=float)
    if len(x) < 2 or not np.all(np.diff(x) > 0.0):
        raise InputError("stations: expected two positions or more, ascending")
    if not len(x) == len(stiffness) == len(mass):
        raise InputError(f"stations: expected {len(x)} sections, one for each position")
    return x
