"""Steady rolling of a thin disc of 2 kg and radius 0.3 m, its axis at 1.2 rad to the vertical.

With A = m r^2 / 4, C = 2 A, the precession W about the vertical and the spin w about the axis,
(C + m r^2) w W sin(theta) = A W^2 sin(theta) cos(theta) - m g r cos(theta); the centre moves in a
circle of radius r w / W.
"""

from math import cos, sin

import numpy as np

m, r, theta, W, g = 2.0, 0.3, 1.2, 3.0, 9.81
A = m * r**2 / 4.0
w = (A * W**2 * sin(theta) * cos(theta) - m * g * r * cos(theta)) / (
    (2.0 * A + m * r**2) * W * sin(theta)
)
axis, up = np.array([sin(theta), 0.0, cos(theta)]), np.array([-cos(theta), 0.0, sin(theta)])
spin = w * axis + W * sin(theta) * up
velocity = np.cross(spin, r * up)


def case(name: str) -> str:
    """Text of the case: contact of the rim with a stiff floor."""
    inertia = A * (np.eye(3) + np.outer(axis, axis))
    return f"""format = 1
title = "{name}"
gravity = [0.0, 0.0, -9.81]
[ground.floor]
position = [0.0, 0.0, 0.0]
[bodies.disc]
kind = "rigid"
mass = {m}
inertia = {inertia.tolist()}
position = [0.0, 0.0, {r * sin(theta)}]
velocity = {velocity.tolist()}
angular_velocity = {spin.tolist()}
interfaces = {{ c = {{ position = [0.0, 0.0, 0.0] }} }}
[forces.floor]
kind = "contact"
between = ["ground.floor", "disc.c"]
radius = {r}
disc_axis = {axis.tolist()}
stiffness = 1e8
coefficient = 1.0
rest_velocity = 1e-5
[solver]
t_end = 2.0
output_step = 0.01
[runs.base]
"""


def truth(times: np.ndarray) -> np.ndarray:
    """Positions (k, 3) of the centre [m]; the velocity turns with W."""
    speed, a = velocity[1], W * times
    x, y = -(1.0 - np.cos(a)) * speed / W, np.sin(a) * speed / W
    return np.stack([x, y, np.full_like(x, r * sin(theta))], axis=1)
