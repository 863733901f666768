"""How a section changes along the beam: initial twist and curvature, taper."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...solver.math.arrays import Array
from .helical import CentralSolutions
from .timoshenko import SectionStiffness

STRONG = 0.5  # least ratio of lengths of fibres at which the result is trusted without a warning
TAPER = 1e-3  # relative error of K by the neglect of taper that is worth a warning


def curvature_of(spec: Mapping[str, Any]) -> Array | None:
    """Initial twist and curvature (3,) [rad/m] of a specification, None for a prismatic beam."""
    k = np.array(spec.get("initial_curvature", (0.0, 0.0, 0.0)), dtype=float)
    return k if k.any() else None


def curvature_warnings(result: SectionStiffness | CentralSolutions) -> list[dict[str, str]]:
    """Warning about a section that is large compared with the radius of curvature."""
    if not isinstance(result, CentralSolutions) or result.strains.least_g >= STRONG:
        return []
    size = float(np.ptp(np.stack([result.space.x2, result.space.x3]), axis=1).max())
    turn = float(np.linalg.norm(result.strains.k)) * size
    return [
        {
            "code": "strongly-curved",
            "message": f"the innermost fibre has {result.strains.least_g:.2g} of the length of the "
            f"reference line (|k| h = {turn:.2g}): end effects reach far, so that a beam is a poor "
            "model",
        }
    ]


def taper_error(
    spec: Mapping[str, Any], points: Array, K: Array
) -> tuple[Array | None, list[dict[str, str]]]:
    """Expected error of K (6, 6) by the neglect of taper, and a warning about it.

    The exact solutions of a wedge of half angle a under axial force and moment (Michell) differ
    from those of a prismatic beam by 2/3 a^2 and 2/5 a^2. The greater is applied to every entry;
    a = taper h / 2 with the largest dimension h of the section.
    """
    taper = float(spec.get("taper", 0.0))
    if taper == 0.0:
        return None, []
    angle = 0.5 * abs(taper) * float(np.ptp(points, axis=0).max())
    error = 2.0 / 3.0 * angle**2
    size = np.sqrt(np.abs(np.diag(K)))
    if error <= TAPER:
        return error * np.outer(size, size), []
    return error * np.outer(size, size), [
        {
            "code": "taper-neglected",
            "message": f"the faces are inclined by {np.degrees(angle):.2g} deg to the axis: the "
            f"stiffness of a prismatic beam is wrong by about {error:.1e}, and shear stresses lack "
            f"{angle:.2g} of the axial ones at the faces",
        }
    ]
