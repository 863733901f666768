"""Drake: trees by its integrators with error control, loops by its discrete solver (SAP).

Its documented choices: `runge_kutta3` with accuracy for smooth plants, `radau3` where stiff; closed
loops need the discrete plant, whose ball constraints are of first order.
"""

from typing import Any

import numpy as np
from common import Sheet, Timed, held, main, not_mechanical

NAME = "Drake"
ENVIRONMENT: dict[str, Any] = {"pip": ["drake==1.51.1", "numpy"]}
FIXED = ("runge_kutta3", "radau3", "implicit_euler", "discrete SAP")  # with fixed steps
JOINTS = {"revolute", "prismatic", "spherical"}


def cannot(sheet: Sheet) -> str:
    """Rigid mechanisms without drives."""
    found = not_mechanical(sheet, JOINTS, ("springs", "motors", "sampled"))
    if not found and any(j.get("drive") for j in sheet["joints"]):
        return "no exact prescribed motion"
    if not found and len(sheet["joints"]) < len(sheet["bodies"]):
        return "free bodies: not in this runner"
    return found


def settings(sheet: Sheet) -> list[Sheet]:
    """Accuracies; steps where loops are closed."""
    if len(sheet["joints"]) > len(sheet["bodies"]):
        first = len(sheet["times"])
        return [{"method": "discrete SAP", "steps": first * 4**k} for k in range(5)]
    return [
        {"method": method, "accuracy": 10.0**-k}
        for method in ("runge_kutta3", "radau3")
        for k in (3, 5, 7, 9, 11)
    ]


def solve(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Build the plant; frames of joints are at the joint, axes global at the start."""
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody import tree
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

    steps = setting.get("steps") if setting["method"] == "discrete SAP" else None
    outputs = len(sheet["times"])
    each = max(1, round(steps / outputs)) if steps else 0
    plant = MultibodyPlant(sheet["t_end"] / (outputs * each) if steps else 0.0)
    plant.mutable_gravity_field().set_gravity_vector(sheet["gravity"])
    bodies = {-1: plant.world_body()}
    for k, b in enumerate(sheet["bodies"]):
        c, m, J = np.array(b["centre"]), b["mass"], np.array(b["inertia"]) / b["mass"]
        unit = tree.UnitInertia(*np.diag(J), J[0, 1], J[0, 2], J[1, 2])
        bodies[k] = plant.AddRigidBody(b["name"], tree.SpatialInertia(m, c, unit))
    data, placed, rest, joints = sheet.get("data", {}), {-1}, list(sheet["joints"]), {}
    loops = []
    while rest:
        open_ends = [
            j for j in rest if (j["one"]["body"] in placed) != (j["two"]["body"] in placed)
        ]
        if not open_ends:
            loops = rest
            break
        joint = open_ends[0]
        rest.remove(joint)
        ends = (joint["one"], joint["two"])
        one, two = ends if ends[0]["body"] in placed else ends[::-1]
        placed.add(two["body"])
        frames = []
        for end in (one, two):
            turn = sheet["bodies"][end["body"]]["rotation"] if end["body"] >= 0 else np.eye(3)
            X = RigidTransform(RotationMatrix(np.array(turn).T), end["point"])
            name = f"{joint['name']}{len(frames)}"
            frames.append(plant.AddFrame(tree.FixedOffsetFrame(name, bodies[end["body"]], X)))
        own = next((s for s in data.get("springs", []) if s["joint"] == joint["name"]), {})
        name, damping = joint["name"], own.get("damping", 0.0)
        if joint["kind"] == "spherical":
            made = tree.BallRpyJoint(name, *frames)
        else:
            kind = tree.RevoluteJoint if joint["kind"] == "revolute" else tree.PrismaticJoint
            made = kind(name, *frames, np.array(joint["axis"]), damping=damping)
        joints[name] = (plant.AddJoint(made), one, two)
        if own.get("stiffness"):
            plant.AddForceElement(tree.PrismaticSpring(joints[name][0], 0.0, own["stiffness"]))
    for joint in loops:
        offsets = [0.0] if joint["kind"] == "spherical" else [0.0, 1.0]
        for offset in offsets:
            places = []
            for end in (joint["one"], joint["two"]):
                turn = sheet["bodies"][end["body"]]["rotation"] if end["body"] >= 0 else np.eye(3)
                axis = np.array(turn).T @ np.array(joint.get("axis") or [0.0, 0.0, 1.0])
                places.append(np.array(end["point"]) + offset * axis)
            pair = [bodies[joint[e]["body"]] for e in ("one", "two")]
            plant.AddBallConstraint(pair[0], places[0], pair[1], places[1])
    driven = {}
    for entry in [*data.get("motors", []), *filter(None, [data.get("sampled")])]:
        driven[entry["joint"]] = len(driven)
        plant.AddJointActuator(f"m{len(driven)}", joints[entry["joint"]][0])
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    spins = {-1: np.zeros(3)}
    for k, b in enumerate(sheet["bodies"]):
        spins[k] = np.array(b["rotation"]) @ np.array(b["spin_body"])
    for joint, one, two in joints.values():
        relative = spins[two["body"]] - spins[one["body"]]
        if joint.type_name() == "revolute":
            joint.set_angular_rate(context, float(relative @ joint.revolute_axis()))
        elif joint.type_name() == "prismatic":
            v = np.array(sheet["bodies"][two["body"]]["velocity"])
            joint.set_translation_rate(context, float(v @ joint.translation_axis()))
        else:
            joint.set_angular_velocity(context, relative)
    config = SimulatorConfig(max_step_size=sheet["t_end"], use_error_control=True)
    if "fixed" in setting:
        config.use_error_control, config.max_step_size = False, setting["fixed"]
    if not steps:
        config.integration_scheme = setting["method"]
        config.accuracy = setting.get("accuracy", config.accuracy)
    ApplySimulatorConfig(config, simulator)
    torque = np.array([m["torque"] for m in data.get("motors", [])] + [0.0] * ("sampled" in data))
    port = plant.get_actuation_input_port()
    probe, rows = bodies[sheet["probe"]["body"]], []
    point = np.array(sheet["probe"]["point"])
    with Timed() as used:
        simulator.Initialize()
        for k, t in enumerate(sheet["times"]):
            if "sampled" in data and k % held(sheet) == 0:
                control = data["sampled"]
                x = joints[control["joint"]][0].get_translation(context)
                torque[-1] = control["gain"] * (control["setpoint"] - x)
            if len(torque) and (k == 0 or "sampled" in data):
                port.FixValue(context, torque)
            simulator.AdvanceTo(t)
            rows.append((probe.EvalPoseInWorld(context) @ point).tolist())
    return rows, used.seconds


if __name__ == "__main__":
    main(solve)
