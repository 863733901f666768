"""Limits of sizes and angles, beyond which a robot is probably in other units."""

# Radius of gyration over the distance from the centre to the farthest joint. Of 1045 moving links
# of 60 robots with an inertia, the least is 0.15; a mass 1e3 too large divides it by 32.
SLIM, WIDE = 0.05, 30.0
LONG = 100.0  # extent of a shape, reach of a link [m]
CLEAR = 0.02  # distance from which on a large ratio says something [m]
MANY_TURNS, DEGREES = 20.0, 720.0  # limits: of 69 robots up to 10 rad, or 1e16 for none
TURNS = 6.3  # of roll, pitch and yaw [rad]: more are degrees
FAR = 1e6  # more than the distance of any place [m], the multiplier of any joint
