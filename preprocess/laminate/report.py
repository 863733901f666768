"""Report on a lay-up: symmetric, balanced, engineering constants."""

from dataclasses import dataclass, replace

import numpy as np

from ...solver.errors import coded
from ...solver.math.arrays import Array
from .stiffness import Lamina, Laminate, ShearCorrection, laminate_stiffness, shear_factors

SAME = 1e-9  # tolerance of thicknesses (relative) and of angles [deg]
COUPLED = 1e-6  # size of B or of A16, A26 above which coupling is reported [-]
ENERGY = ("energy-1d", "energy-2x2")  # of the lay-up itself: never too stiff
SOFT = 0.3  # factor of the transverse shear below which the core carries the shear [-]
STIFF = 1.1  # given factors over those of the lay-up, above which they are too stiff


@dataclass(frozen=True)
class LaminateReport:
    """Properties of a laminate in addition to its stiffness.

    `coupling` is the largest B_ij / sqrt(A_ii D_jj) about the mid-plane, `shear_extension` the
    largest A_i6 / sqrt(A_ii A_66). `membrane` holds Ex, Ey, Gxy [Pa] and nuxy of the laminate
    held flat, from A^-1 / h; `bending` the same of its bending, from D^-1 h^3 / 12 about the
    mid-plane with N = 0. They are the constants of one equivalent ply if the laminate is
    symmetric.
    """

    symmetric: bool
    balanced: bool
    coupling: float
    shear_extension: float
    membrane: dict[str, float]
    bending: dict[str, float]
    shear_factors: tuple[float, float]  # of "energy-1d", for comparison [-]
    findings: tuple[dict[str, str], ...]  # {"code", "message"}


def report(
    laminate: Laminate, name: str = "laminate", shear: ShearCorrection = "energy-1d"
) -> LaminateReport:
    """Return the report on a lay-up.

    Parameters
    ----------
    laminate : plies, bottom to top
    name : of the laminate, for messages
    shear : shear correction that is judged
    """
    flat = laminate_stiffness(replace(laminate, offset=0.0))
    A, B, D, h = flat.A, flat.B, flat.D, flat.thickness
    coupling = float(np.max(np.abs(B) / np.sqrt(np.outer(np.diag(A), np.diag(D)))))
    extension = float(np.max(np.abs(A[:2, 2]) / np.sqrt(np.diag(A)[:2] * A[2, 2])))
    bending: Array = np.asarray(D - B @ np.linalg.solve(A, B), dtype=float)
    symmetric, balanced = is_symmetric(laminate), is_balanced(laminate)
    factors = shear_factors(laminate, "energy-1d")
    findings = []
    if not symmetric and coupling > COUPLED:
        findings += coded(
            "laminate-unsymmetric",
            f"{name}: not symmetric, extension and bending are coupled "
            f"(B is {coupling:.2g} of sqrt(A D)): it warps when it is cured or heated",
        )
    if not balanced and extension > COUPLED:
        findings += coded(
            "laminate-unbalanced",
            f"{name}: not balanced, extension causes shear "
            f"(A16, A26 are {extension:.2g} of sqrt(A11 A66))",
        )
    given = factors if shear in ENERGY else shear_factors(laminate, shear)
    if ((factors < SOFT) & (given > STIFF * factors)).any():
        findings += coded(
            "laminate-soft-core",
            f"{name}: shear factors {given[0]:.3g}, {given[1]:.3g} are too stiff: a soft core "
            f'carries the shear, and "energy-1d" gives {factors[0]:.2g}, {factors[1]:.2g}; take '
            'it or "energy-2x2"',
        )
    return LaminateReport(
        symmetric,
        balanced,
        coupling,
        extension,
        _constants(A / h),
        _constants(bending * 12.0 / h**3),
        (float(factors[0]), float(factors[1])),
        tuple(findings),
    )


def is_symmetric(laminate: Laminate) -> bool:
    """True if the plies are the same seen from both faces, for any offset."""
    plies = laminate.plies
    return all(_same(a, b) for a, b in zip(plies, reversed(plies), strict=True))


def is_balanced(laminate: Laminate) -> bool:
    """True if each material has equal thickness at +angle and -angle (0 and 90 deg are ignored)."""
    excess: dict[tuple[object, float], float] = {}
    for material, angle_deg, thickness in laminate.plies:
        angle = _turned(angle_deg)
        if abs(angle) < SAME or abs(abs(angle) - 90.0) < SAME:
            continue
        key = (material, round(abs(angle), 6))
        excess[key] = excess.get(key, 0.0) + np.sign(angle) * thickness
    return all(abs(rest) <= SAME * laminate.thickness for rest in excess.values())


def _same(a: Lamina, b: Lamina) -> bool:
    turn = abs(_turned(a.angle_deg) - _turned(b.angle_deg))
    return (
        a.material == b.material
        and abs(a.thickness - b.thickness) <= SAME * a.thickness
        and min(turn, 180.0 - turn) <= SAME
    )


def _turned(angle_deg: float) -> float:
    """The equivalent fibre angle between -90 and 90 deg."""
    return (angle_deg + 90.0) % 180.0 - 90.0


def _constants(Q: Array) -> dict[str, float]:
    """Engineering constants of a stiffness in plane stress (3, 3) [Pa]."""
    S = np.linalg.inv(Q)
    return {
        "Ex": float(1.0 / S[0, 0]),
        "Ey": float(1.0 / S[1, 1]),
        "Gxy": float(1.0 / S[2, 2]),
        "nuxy": float(-S[0, 1] / S[0, 0]),
    }
