"""Doubts about a finished run, each with a code and words that say what helps."""

from typing import Any

import numpy as np

from ..math.arrays import Array
from ..mechanism import BuiltMechanism

Finding = dict[str, str]

DRIFT_TOLERANCE = 1e-6  # [m]
ENERGY_TOLERANCE = 1e-3  # relative
ROTATION_TOLERANCE = 0.1  # [rad]
MOMENTUM_TOLERANCE = 1e-8  # relative
LAST_MODE_SHARE = 0.02  # of the peak strain energy
VIBRATION = ("fixed_normal", "experimental")  # kinds of modes, of package.schema.MODE_KINDS


def finding(code: str, message: str) -> Finding:
    """Return one warning of summary.json."""
    return {"code": code, "message": message}


def of_checks(checks: dict[str, Any]) -> list[Finding]:
    """Doubts from the numbers of the run: constraints, energy balance, freedom to move."""
    found = []
    if checks["constraint_position_max"] > DRIFT_TOLERANCE:
        found.append(
            finding(
                "constraint-drift",
                f"joined points are up to {checks['constraint_position_max']:.2g} m apart "
                f"(expected below {DRIFT_TOLERANCE:g} m): tighten rtol and atol, or take "
                'constraints = "projection"',
            )
        )
    locked = checks["degrees_of_freedom"] == 0  # nothing moves: there is no energy to balance
    if checks["energy_drift_relative"] > ENERGY_TOLERANCE and not locked:
        found.append(
            finding(
                "energy-drift",
                f"the energy balance is off by {checks['energy_drift_relative']:.2g} of the energy "
                f"in play (expected below {ENERGY_TOLERANCE:g}): tighten rtol and atol",
            )
        )
    if locked:
        found.append(
            finding(
                "mechanism-locked",
                "joints leave no motion at the start: all bodies stand still whatever pushes them; "
                "flexible bodies, or joints that leave more freedom, let it move",
            )
        )
    if checks["momentum_balance"] > MOMENTUM_TOLERANCE:
        found.append(
            finding(
                "momentum-balance",
                "loads and reactions miss the change of momentum by "
                f"{checks['momentum_balance']:.2g} of the largest force (expected below "
                f"{MOMENTUM_TOLERANCE:g}): do not trust the reactions",
            )
        )
    return found


def of_motion(built: BuiltMechanism, y: Array) -> list[Finding]:
    """Doubts from the elastic motion, body by body: large rotations, too few modes."""
    found = []
    for i, name in enumerate(built.body_names):
        m = int(built.model.n_mode[i])
        if m == 0:
            continue
        a = int(built.model.pos_start[i]) + 7
        q = y[:, a : a + m]
        rotation = max(
            float(np.max(np.linalg.norm(q @ interface.psi_B.T, axis=1)))
            for interface in built.packages[name].interfaces
        )
        if rotation > ROTATION_TOLERANCE:
            second_order = built.model.second_start[i + 1] > built.model.second_start[i]
            found.append(_of_rotation(name, rotation, second_order=bool(second_order)))
        package = built.packages[name]
        # A static shape carries what it carries: only a series of vibration modes can be too short.
        vibration = [k for k, kind in enumerate(package.mode_kinds) if kind in VIBRATION]
        energy = 0.5 * np.diag(package.stiffness) * q**2
        peak = float(energy.sum(axis=1).max())
        share = float(energy[:, vibration[-1]].max()) / peak if vibration and peak > 0 else 0.0
        if m > 1 and share > LAST_MODE_SHARE:
            found.append(
                finding(
                    "modes-too-few",
                    f"{name}: the highest of {len(vibration)} vibration modes carries {share:.1%} "
                    f"of the peak strain energy (expected below {LAST_MODE_SHARE:.0%}): take more "
                    "modes, or static ones where forces act",
                )
            )
    return found


def _of_rotation(name: str, rotation: float, *, second_order: bool) -> Finding:
    turn = f"{name}: an interface turns by {rotation:.2f} rad relative to the body frame "
    if second_order:
        text = (
            f"{turn}(second-order body: below {ROTATION_TOLERANCE:g} rad; expect an error of about "
            "2 % at 0.25 rad): use a chord or mean-axis frame, or split the body"
        )
    else:
        text = (
            f"{turn}(linear bodies: below {ROTATION_TOLERANCE:g} rad): split the body or stiffen it"
        )
    return finding("elastic-rotation-large", text)
