"""Tolerances of the equations of motion: closed joints, rank, elimination, forces, the rotor.

Rounding is that of double precision, 1.1e-16, times what the operation enlarges it by.
"""

# Distance [m] of two places that have no direction from one to the other; and length [m] that a
# rod between them needs.
NO_DIRECTION = 1e-12
LEAST_LENGTH = 1e-9

# Speed of a body that stands still [m/s, rad/s, 1/s].
STANDS_STILL = 1e-9

# Half angle of a turn below which sin(x) / x is 1: the difference is x^2 / 6.
SMALL_TURN = 1e-8

# Pivots below which elimination leaves no digit: above, orders of magnitude are right, and the time
# stays linear in the number of bodies, because the pivots of a chain fall with its length. Load
# over that which the kinetic energy or the largest force stands for, below which it is none.
ORDER_OF_MAGNITUDE = 1e-12
NO_LOAD = 1e-3

# Projection. |Phi| that is rounding, for each metre of the largest position [m, rad]: what is left
# of Phi moves bodies by |Phi| / s, with s the least singular value of Phi_q; 1e-12 left 1e-5 m per
# passage of a singular position, where s is small, at any rtol. Roundings that the next correction
# would move bodies by, too few to compute it. |Phi| that is accepted if round-off prevents a
# smaller one [m, rad]. Change of velocities over the velocities that is rounding.
CLOSED = 1e-15
SPARED = 100.0
STAYS_CLOSED_TO = 1e-9
SAME_VELOCITIES = 1e-15

# Ratio of a pivot to its diagonal entry below which rows are treated as dependent and the penalty
# is used: an elimination without it would lose more than half of the digits. Rows that are
# independent have a multiple of it, of the geometry alone.
REGULAR = 1e-7
CLEARLY_REGULAR = 1e3 * REGULAR

# Singular values of constraint rows over the largest: of rows that follow from others, for the
# least-squares solution; and of rows of length one that are independent for certain.
RANK_TOLERANCE = 1e-9
INDEPENDENT = 1e3 * RANK_TOLERANCE

# Rank of the constraints: singular values below the first are zero, relative to the largest. Where
# those on both sides differ by less than RANK_GAP, the widest gap between the values of
# RANK_GAP_WITHIN decides; a value of zero is computed as the last.
RANK_CUT = 1e-6
RANK_GAP = 1e2
RANK_GAP_WITHIN = (1e-9, 1e-3)
ZERO_SINGULAR = 1e-16

# Least pivot, over its diagonal entry, of a step that has no singular position.
CERTAIN = 1e-10

# Smallest singular value by shifts: distance of the last shift from the eigenvalue, relative;
# eigenvalues of C C' that are zero, and where some are zero by themselves; rounding in the residual
# of an eigenvector.
SHIFT_FOUND = 1e-7
LEAST_EIGENVALUE, LEAST_BESIDE_ZEROS = 1e-17, 1e-14
RESIDUAL_ROUNDING = 1e-15

# Least eigenvalue of a mass matrix scaled to a diagonal of one: that leaves enough digits to an
# elimination; and above rounding, which a heavy mass on a light body comes close to. Singular
# values over the largest, of the motions of masses added to a body; and of joint rows.
POSITIVE_MASS, MASS_ROUNDING = 1e-10, 1e-13
MOVED, HELD = 1e-6, 1e-9

# Forces that read reactions: what a force may miss, over its size and over the largest multiplier.
REACTION_FOUND, REACTION_ROUNDING = 1e-11, 1e-14

# Instants: the part of a step, of the time at the end of a run, and of the period of a controller
# within which two are one.
ONE_INSTANT = 1e-13
LAST_INSTANT = 1e-14
ONE_SAMPLE = 1e-6

# Impacts: slower ones lose more than the restitution says [m/s, rad/s]; restitution that is one.
SLOWEST_IMPACT = 1e-6
FULL_RESTITUTION = 1.0 - 1e-9

# Inflow of a rotor at rest: change over the size that ends the iteration. Numbers that are divided
# by are not smaller: wind along the shaft and flow at a section [m/s], distance from the shaft [m],
# sine of the inflow angle, loss at tip and root.
INFLOW_FOUND = 1e-9
LEAST_WIND, LEAST_FLOW, LEAST_RADIUS = 0.1, 1e-3, 1e-6
LEAST_SINE, LEAST_LOSS = 1e-6, 1e-3

# Squared frequency of a motion without strain, over the largest.
WITHOUT_STRAIN = 1e-10
