"""Limits of sizes and angles, beyond which a robot is probably in other units."""

# Radius of gyration over the distance from the centre to the farthest joint. Of the moving links of
# 120 robots with an inertia, the least is 0.034; an origin in mm divides it by 1e3.
SLIM, WIDE = 0.02, 30.0
# Density [kg/m3] of a ball with the mass and the moments of a link: half of the mass of each of 67
# robots has less than 15 to 2300. Osmium has 22,600; with masses in g, 66 of them have more. In mm
# (and kg mm2) all have less than 1e-5.
LIGHT, DENSE = 1e-3, 22_600.0
LONG = 100.0  # extent of a shape, reach of a link [m]
CLEAR = 0.02  # distance from which on a large ratio says something [m]
MANY_TURNS, DEGREES = 20.0, 720.0  # limits: of 69 robots up to 10 rad, or 1e16 for none
TURNS = 6.3  # of roll, pitch and yaw [rad]: more are degrees
FAR = 1e6  # more than the distance of any place [m], the multiplier of any joint
