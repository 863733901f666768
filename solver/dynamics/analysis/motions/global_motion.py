"""Global position of a place and its derivatives."""

from .contract import Motion

POSITION = Motion("position", "global", "m", lambda r, marker: r.position(marker), order=1)
VELOCITY = Motion("velocity", "global", "m/s", lambda r, marker: r.velocity(marker), order=2)
ACCELERATION = Motion("acceleration", "global", "m/s2", lambda r, m: r.acceleration(m), order=3)
SPIN = Motion("angular_velocity", "global", "rad/s", lambda r, marker: r.spin(marker), order=4)
