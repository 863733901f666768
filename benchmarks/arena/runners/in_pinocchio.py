"""Pinocchio (articulated-body algorithm) under SciPy's DOP853: rigid trees of hinges and guides.

Pinocchio gives accelerations and no integrator of its own with error control; DOP853 at a tolerance
is the usual choice. Its times are those of a Python loop around compiled dynamics.
"""

from typing import Any

import numpy as np
from common import Sheet, Timed, held, main, not_mechanical

NAME = "Pinocchio"
ENVIRONMENT: dict[str, Any] = {"pip": ["pin==4.1.0", "scipy", "numpy"]}


def cannot(sheet: Sheet) -> str:
    """Rigid trees without drives."""
    found = not_mechanical(sheet, {"revolute", "prismatic"}, ("springs", "motors", "sampled"))
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
    n, given = model.nv, sheet.get("data", {})
    torque, stiffness, damping = np.zeros((3, n))
    dofs = {name: model.joints[k].idx_v for k, name in enumerate(model.names) if k}
    for spring in given.get("springs", []):
        stiffness[dofs[spring["joint"]]] = spring.get("stiffness", 0.0)
        damping[dofs[spring["joint"]]] = spring["damping"]
    for motor in given.get("motors", []):
        torque[dofs[motor["joint"]]] = motor["torque"]

    def rates(_: float, y: Any) -> Any:
        force = torque - stiffness * y[:n] - damping * y[n:]
        return np.concatenate([y[n:], pin.aba(model, data, y[:n], y[n:], force)])

    y0 = np.concatenate([pin.neutral(model), v0])
    times, rows, sampled = np.array(sheet["times"]), [], given.get("sampled")
    blocks = np.split(times, range(held(sheet), len(times), held(sheet))) if sampled else [times]
    t0, y = 0.0, y0
    with Timed() as used:
        for block in blocks:
            if sampled:
                at = dofs[sampled["joint"]]
                torque[at] = sampled["gain"] * (sampled["setpoint"] - y[at])
            rtol = setting["rtol"]
            found = solve_ivp(
                rates, (t0, block[-1]), y, "DOP853", block, rtol=rtol, atol=rtol * 0.1
            )
            if not found.success:
                raise RuntimeError(found.message)
            t0, y = block[-1], found.y[:, -1]
            for q in found.y[:n].T:
                pin.forwardKinematics(model, data, q)
                rows.append((data.oMi[joints[probe["body"]]] * tip).tolist())
    return rows, used.seconds


if __name__ == "__main__":
    main(solve)
