"""Global position of a place and its derivatives."""

from ..recovery import Recording
from .contract import Motion

POSITION = Motion("position", "global", "m", Recording.position, order=1)
VELOCITY = Motion("velocity", "global", "m/s", Recording.velocity, order=2)
ACCELERATION = Motion("acceleration", "global", "m/s2", Recording.acceleration, order=3)
SPIN = Motion("angular_velocity", "global", "rad/s", Recording.spin, order=4)
