"""Limits of sizes and angles, beyond which a robot is probably in other units."""

# Radius of gyration over the distance from the centre to the farthest joint. Of the moving links of
# 120 robots with an inertia, the least is 0.034; an origin in mm divides it by 1e3.
SLIM, WIDE = 0.02, 30.0
# Density [kg/m3] of a ball with the mass and the moments of a link: of 120 robots up to 8e8, as
# frames have moments that are too small; with masses in g, of one link of each robot 1.7e9 or more.
DENSE = 1.2e9
LONG = 100.0  # extent of a shape, reach of a link [m]
CLEAR = 0.02  # distance from which on a large ratio says something [m]
MANY_TURNS, DEGREES = 20.0, 720.0  # limits: of 69 robots up to 10 rad, or 1e16 for none
TURNS = 6.3  # of roll, pitch and yaw [rad]: more are degrees
FAR = 1e6  # more than the distance of any place [m], the multiplier of any joint
