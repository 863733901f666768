"""Pinocchio (articulated-body algorithm) under SciPy's DOP853: rigid trees of hinges and guides.

Pinocchio gives accelerations and no integrator of its own with error control; DOP853 at a tolerance
is the usual choice. Its times are those of a Python loop around compiled dynamics.
"""

from typing import Any

import numpy as np
from common import Sheet, Timed, main, not_mechanical

NAME = "Pinocchio"
ENVIRONMENT: dict[str, Any] = {"pip": ["pin==4.1.0", "scipy", "numpy"]}


def cannot(sheet: Sheet) -> str:
    """Rigid trees without drives."""
    found = not_mechanical(sheet, {"revolute", "prismatic"})
    if found:
        return found
    if len(sheet["joints"]) != len(sheet["bodies"]):
        return "loops or free bodies: trees only in this runner"
    if any(j.get("drive") for j in sheet["joints"]):
        return "no prescribed motion in forward dynamics"
    return str(sheet.get("data", {}).get("pinocchio", ""))


def settings(sheet: Sheet) -> list[Sheet]:
    """Tolerances."""
    return [{"method": "DOP853", "rtol": r} for r in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)]


def solve(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Integrate joint angles."""
    import pinocchio as pin
    from scipy.integrate import solve_ivp

    model = pin.Model()
    model.gravity.linear = np.array(sheet["gravity"])
    # frames of joints: at the joint, axes global at the start
    joints, places, v0 = {-1: 0}, {-1: np.zeros(3)}, []
    spins = {-1: np.zeros(3)}
    rest = list(sheet["joints"])
    while rest:
        joint = next(
            j for j in rest if (j["one"]["body"] in joints) != (j["two"]["body"] in joints)
        )
        rest.remove(joint)
        ends = (joint["one"], joint["two"])
        one, two = ends if ends[0]["body"] in joints else ends[::-1]
        parent, k = one["body"], two["body"]
        body, axis = sheet["bodies"][k], np.array(joint["axis"])
        axis = axis / np.linalg.norm(axis)
        place, R = np.array(two["global"]), np.array(body["rotation"])
        turns = joint["kind"] == "revolute"
        kind = (pin.JointModelRevoluteUnaligned if turns else pin.JointModelPrismaticUnaligned)(
            axis
        )
        offset = pin.SE3(np.eye(3), place - places[parent])
        joints[k] = model.addJoint(joints[parent], kind, offset, joint["name"])
        places[k], spins[k] = place, R @ np.array(body["spin_body"])
        c, m = np.array(body["centre"]), body["mass"]
        J = np.array(body["inertia"]) - m * (c @ c * np.eye(3) - np.outer(c, c))
        at = np.array(body["position"]) + R @ c - place
        model.appendBodyToJoint(joints[k], pin.Inertia(m, at, R @ J @ R.T), pin.SE3.Identity())
        relative = spins[k] - spins[parent] if turns else np.array(body["velocity"])
        v0.append(relative @ axis)
    data = model.createData()
    probe = sheet["probe"]
    tip = np.array(probe["global"]) - places[probe["body"]]
    n, torque = model.nv, np.zeros(model.nv)

    def rates(_: float, y: Any) -> Any:
        return np.concatenate([y[n:], pin.aba(model, data, y[:n], y[n:], torque)])

    y0 = np.concatenate([pin.neutral(model), v0])
    with Timed() as used:
        found = solve_ivp(
            rates,
            (0.0, sheet["t_end"]),
            y0,
            "DOP853",
            sheet["times"],
            rtol=setting["rtol"],
            atol=setting["rtol"] * 0.1,
        )
        rows = []
        for q in found.y[:n].T:
            pin.forwardKinematics(model, data, q)
            rows.append((data.oMi[joints[probe["body"]]] * tip).tolist())
    if not found.success:
        raise RuntimeError(found.message)
    return rows, used.seconds


if __name__ == "__main__":
    main(solve)
