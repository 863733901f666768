"""Data of the test set: bodies with the x axes that it gives them, all joints hinges about z."""

import numpy as np

BETA, GAMMA, DELTA = -0.0617138900142764, 0.4552798191630704, 0.4873649795438426
PHI, EPSILON = 0.2226683901658859, 1.230547444549821
GROUND, A, B, C = (0.0, 0.0), (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)
AXIS = np.array([np.cos(BETA), np.sin(BETA)])
PIN, E = 0.007 * AXIS, -0.021 * AXIS
# mass, inertia about the centre, angle of x, origin, centre, interfaces
BODIES = {
    "k1": (0.04325, 2.194e-6, BETA, GROUND, (0.00092, 0.0), {"o": (0.0, 0.0), "pin": (0.007, 0.0)}),
    "k2": (0.00365, 4.41e-7, BETA, PIN, (-0.0115, 0.0), {"pin": (0.0, 0.0), "e": (-0.028, 0.0)}),
    "k3": (0.02373, 5.255e-6, GAMMA, B, (0.01043, -0.01874),
           {"b": (0.0, 0.0), "e": (0.0, -0.035), "d": (0.02, -0.018)}),
    "k4": (0.00706, 5.667e-7, PHI + DELTA, E, (0.0, 0.01421), {"e": (0.0, 0.0), "h": (0.0, 0.02)}),
    "k5": (0.0705, 1.169e-5, DELTA, A, (0.02308, 0.00916), {"a": (0.0, 0.0), "h": (0.04, 0.0)}),
    "k6": (0.00706, 5.667e-7, EPSILON - PHI, E, (-0.01421, 0.0),
           {"e": (0.0, 0.0), "g": (-0.02, 0.0)}),
    "k7": (0.05498, 1.912e-5, EPSILON, A, (-0.00449, -0.01228),
           {"a": (0.0, 0.0), "g": (0.0, -0.04)}),
}  # fmt: skip
HINGES = ("ground.o k1.o", "k1.pin k2.pin", "k2.e k3.e", "k2.e k4.e", "k2.e k6.e", "ground.b k3.b")
HINGES += ("k4.h k5.h", "ground.a k5.a", "k6.g k7.g", "ground.a k7.a")


def case(name: str) -> str:
    """Text of the case."""

    def at(point: tuple[float, float]) -> str:
        return f"position = [{point[0]!r}, {point[1]!r}, 0.0]"

    lines = ["format = 1", f'title = "{name}"']
    for place, point in zip("oabc", (GROUND, A, B, C), strict=True):
        lines += [f"[ground.{place}]", at(point)]
    for body, (mass, inertia, angle, origin, centre, points) in BODIES.items():
        lines += [f"[bodies.{body}]", 'kind = "rigid"', f"mass = {mass}"]
        rows = ([inertia, 0.0, 0.0], [0.0, inertia, 0.0], [0.0, 0.0, inertia])
        lines += [f"inertia = {[*rows]}", f"centre = [{centre[0]}, {centre[1]}, 0.0]"]
        lines += [at((float(origin[0]), float(origin[1])))]
        lines += [f"rotation_deg = [0.0, 0.0, {float(np.degrees(angle))!r}]"]
        lines += [f"interfaces.{name} = {{ {at(point)} }}" for name, point in points.items()]
    for k, between in enumerate(HINGES):
        one, two = between.split()
        lines += [f"[joints.hinge-{k}]", 'kind = "revolute"', f'between = ["{one}", "{two}"]']
        lines += ["axis = [0.0, 0.0, 1.0]"]
    lines += ["[forces.motor]", 'kind = "torque"', 'at = "k1.o"', "direction = [0.0, 0.0, 1.0]"]
    lines += ["law = { constant = 0.033 }", "[forces.spring]", 'kind = "spring"']
    lines += ['between = ["ground.c", "k3.d"]', "stiffness = 4530.0", "length = 0.07785"]
    return "\n".join([*lines, "[solver]", "t_end = 0.03", "output_step = 0.03", "[runs.base]", ""])


def truth(times: np.ndarray) -> np.ndarray:
    """Position (1, 3) of the crank's pin [m]."""
    beta = 15.81077119629904
    return np.array([[0.007 * np.cos(beta), 0.007 * np.sin(beta), 0.0]])
