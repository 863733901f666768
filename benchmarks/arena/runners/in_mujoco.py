"""MuJoCo: rigid trees in minimal coordinates; loops closed by soft equalities.

Its documented choices: RK4 (trees) and implicitfast; equalities as stiff as the step allows
(solref of two steps, solimp near one), Newton's solver to 1e-12.
"""

from typing import Any

import numpy as np
from common import Sheet, Timed, held, main, not_mechanical

NAME = "MuJoCo"
ENVIRONMENT: dict[str, Any] = {"pip": ["mujoco==4.0.0", "numpy"]}
FIXED = ("Euler", "RK4", "implicit", "implicitfast")  # with fixed steps
JOINTS = {"revolute": "hinge", "prismatic": "slide", "spherical": "ball"}
MOST = 200_000  # steps


def cannot(sheet: Sheet) -> str:
    """Rigid mechanisms without drives."""
    forces = ("spring", "springs", "motors", "sampled")
    found = not_mechanical(sheet, {*JOINTS, "point_on_line"}, forces)
    if not found and any(j.get("drive") for j in sheet["joints"]):
        return "no exact prescribed motion"
    return found or str(sheet.get("data", {}).get("mujoco", ""))


def settings(sheet: Sheet) -> list[Sheet]:
    """Steps, a factor of four at a time."""
    methods = ["RK4", "implicitfast"]
    first = max(50, int(50 * sheet["t_end"]))
    return [
        {"method": m, "steps": first * 4**k}
        for m in methods
        for k in range(8)
        if first * 4**k <= MOST
    ]


def row(values: Any) -> str:
    """Numbers of an attribute."""
    return " ".join(f"{v:.17g}" for v in np.ravel(values))


def tree(sheet: Sheet) -> tuple[list[tuple[int, int, Sheet]], list[Sheet]]:
    """Joints that carry a body (parent, child, joint), parents first; those that close loops."""
    placed, carried, rest = {-1}, [], list(sheet["joints"])
    moved = True
    while moved:
        moved = False
        for joint in list(rest):
            a, b = joint["one"]["body"], joint["two"]["body"]
            if (a in placed) != (b in placed) and joint["kind"] in JOINTS:
                parent, child = (a, b) if a in placed else (b, a)
                carried.append((parent, child, joint))
                placed.add(child)
                rest.remove(joint)
                moved = True
    return carried, rest


def xml(sheet: Sheet, h: float, method: str) -> str:
    """The model; frames of bodies are those of the sheet."""
    bodies = sheet["bodies"]
    carried, loops = tree(sheet)
    children: dict[int, list[tuple[int, Sheet | None]]] = {}
    for parent, child, joint in carried:
        children.setdefault(parent, []).append((child, joint))
    free = set(range(len(bodies))) - {c for _, c, _ in carried}
    for k in free:
        children.setdefault(-1, []).append((k, None))

    def frame(k: int) -> tuple[Any, Any]:
        if k < 0:
            return np.zeros(3), np.eye(3)
        return np.array(bodies[k]["position"]), np.array(bodies[k]["rotation"])

    def element(k: int, parent: int, joint: Sheet | None) -> str:
        (r0, R0), (r, R), body = frame(parent), frame(k), bodies[k]
        c, m = np.array(body["centre"]), body["mass"]
        J = np.array(body["inertia"]) - m * (c @ c * np.eye(3) - np.outer(c, c))
        turn = R0.T @ R
        text = f'<body name="b{k}" pos="{row(R0.T @ (r - r0))}" xyaxes="{row(turn.T[:2])}">'
        full = J[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        text += f'<inertial pos="{row(c)}" mass="{m:.17g}" fullinertia="{row(full)}"/>'
        if joint is None:
            text += f'<freejoint name="j{k}"/>'
        else:
            end = joint["one"] if joint["one"]["body"] == k else joint["two"]
            axis = R.T @ np.array(joint.get("axis") or [0, 0, 1])
            kind = JOINTS[joint["kind"]]
            text += f'<joint name="j{k}" type="{kind}" pos="{row(end["point"])}"'
            text += f' axis="{row(axis)}"' if kind != "ball" else ""
            spring = sheet.get("data", {}).get("spring", {})
            if spring.get("joint") == joint["name"]:
                text += f' stiffness="{spring["stiffness"]}" springref="{spring["rest"]}"'
                text += f' frictionloss="{spring["coulomb"]}" solreffriction="{2 * h:.17g} 1"'
                text += ' solimpfriction="0.9999 0.9999 0.001"'
            for own in sheet.get("data", {}).get("springs", []):
                if own["joint"] == joint["name"]:
                    text += f' stiffness="{own.get("stiffness", 0)}" damping="{own["damping"]}"'
            text += "/>"
        if sheet["probe"]["body"] == k:
            text += f'<site name="probe" pos="{row(sheet["probe"]["point"])}"/>'
        return text + "".join(element(c, k, j) for c, j in children.get(k, [])) + "</body>"

    equal = []
    for joint in loops:
        one, two = joint["one"], joint["two"]
        names = [f"b{e['body']}" if e["body"] >= 0 else "world" for e in (one, two)]
        local = np.array(one["point"])
        anchors = [local]
        if joint["kind"] == "revolute" and one["body"] >= 0:
            axis = np.array(bodies[one["body"]]["rotation"]).T @ np.array(joint["axis"])
            anchors.append(local + axis)
        elif joint["kind"] == "revolute":
            anchors.append(local + np.array(joint["axis"]))
        for a in anchors:
            equal.append(
                f'<connect body1="{names[0]}" body2="{names[1]}" anchor="{row(a)}" '
                f'solref="{2 * h:.17g} 1" solimp="0.9999 0.9999 0.001"/>'
            )
    world = "".join(element(k, -1, j) for k, j in children.get(-1, []))
    return (
        f'<mujoco><compiler autolimits="true" inertiafromgeom="false"/>'
        f'<option timestep="{h:.17g}" integrator="{method}" gravity="{row(sheet["gravity"])}" '
        f'tolerance="1e-12" iterations="200"><flag contact="disable"/></option>'
        f"<worldbody>{world}</worldbody><equality>{''.join(equal)}</equality></mujoco>"
    )


def solve(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Step to every output."""
    import mujoco

    outputs = len(sheet["times"])
    each = max(1, round(setting["steps"] / outputs))
    model = mujoco.MjModel.from_xml_string(
        xml(sheet, sheet["t_end"] / (outputs * each), setting["method"])
    )
    data = mujoco.MjData(model)
    spins = [np.array(b["rotation"]) @ np.array(b["spin_body"]) for b in sheet["bodies"]]
    for parent, k, joint in tree(sheet)[0]:
        R = np.array(sheet["bodies"][k]["rotation"])
        spin = spins[k] - (spins[parent] if parent >= 0 else 0.0)
        at = model.joint(f"j{k}").dofadr[0]
        kind = JOINTS[joint["kind"]]
        if kind == "hinge":
            data.qvel[at] = spin @ np.array(joint["axis"])
        elif kind == "ball":
            data.qvel[at : at + 3] = R.T @ spin
        else:
            data.qvel[at] = np.array(sheet["bodies"][k]["velocity"]) @ np.array(joint["axis"])
    for k, body in enumerate(sheet["bodies"]):
        name = f"j{k}"
        if model.joint(name).type[0] == mujoco.mjtJoint.mjJNT_FREE:
            at = model.joint(name).dofadr[0]
            data.qvel[at : at + 6] = [*body["velocity"], *body["spin_body"]]
    dofs = {j["name"]: model.joint(f"j{k}").dofadr[0] for _, k, j in tree(sheet)[0]}
    for motor in sheet.get("data", {}).get("motors", []):
        data.qfrc_applied[dofs[motor["joint"]]] = motor["torque"]
    sampled, rows = sheet.get("data", {}).get("sampled"), []
    with Timed() as used:
        for k in range(outputs):
            if sampled and k % held(sheet) == 0:
                at = dofs[sampled["joint"]]
                data.qfrc_applied[at] = sampled["gain"] * (sampled["setpoint"] - data.qpos[at])
            mujoco.mj_step(model, data, each)
            mujoco.mj_kinematics(model, data)
            rows.append(data.site("probe").xpos.tolist())
    return rows, used.seconds


if __name__ == "__main__":
    main(solve)
