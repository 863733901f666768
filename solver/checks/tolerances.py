"""Limits of the checks of a run: what is small, what is the same, what is found."""

# Smallest singular value of the joints over the largest that it had in the run: in a singular
# position, and near one, where its minimum is searched. Change of the scaled Jacobian in a part of
# a step that has one minimum at most; parts that are not divided, and accuracy of the time of a
# minimum, of a step.
AT_SINGULAR, NEARLY_SINGULAR = 1e-3, 0.05
ONE_MINIMUM = 0.5
LEAST_PART, MINIMUM_FOUND, AHEAD = 0.02, 1e-5, 1e-6

# Passage of a singular position without harm: change of velocity, relative; loss of energy, of the
# energy in play; time there over the time that the acceleration explains. Share of a joint in the
# motion that names it, of the largest.
UNTURNED, UNDAMPED = 0.2, 1e-3
EXPLAINED = 10.0
NAMED = 0.1

# Pivot over the one where the singular value was computed last, beyond which it is computed again.
LOWER_PIVOT, HIGHER_PIVOT = 0.25, 4.0

# Motion that grows: each of the last parts of a run over the one before. No power of time that
# loads or drives follow grows so fast: in the last tenth t^n grows by (10/9)^n, which is 3 for
# n = 10; the kinetic energy of a smooth step begins with t^6 at most.
GROWTH_OF_A_TENTH = 3.0

# Share of the strain energy of a vibration that makes it one of a body: two like members of an arm
# have half each, so that a larger share would pass over their bending.
OF_ONE_BODY = 0.25

# Growth over the spin that a run passes by: that of a shaft whose two stiffnesses differ by 4 %, by
# (w_2 - w_1) / 2 between its critical speeds; meshed round shafts differ by less.
SLOW_GROWTH = 0.01

# Directions of motion that are one, and strain that is none, relative; difference of spins that is
# judged once, relative; accuracy of the time of a loss of stability [s], over the time; times that
# are one, of the run; differences on both sides, of the size of the mechanism or rad.
ONE_DIRECTION = 1e-6
SAME_SPIN = 1e-3
LOSS_FOUND = 1e-9
SAME_TIME = 1e-6
DIFFERENCE_STEP = 1e-5

# Of the deformation that loads of this size cause where the body is softest: less is left out on
# purpose, as the stretch of a body of length L and height h, (h / 2 L)^2 of its deflection.
SLIGHT = 1e-3

# Mean strain energy of a vibration that a sudden load starts, over the static one. Energy of a load
# alone, of the largest: it gets no shape of its own. Load that is rounding, of the load of a body
# and of what it carries. Offset of stations of a straight beam, of its size.
OVERSHOOT = 1.5
SMALL_LOAD = 1e-4
LOAD_ROUNDING = 1e-6
STRAIGHT = 1e-9

# Part of the stiffness that a spin takes in the frame: at half a frequency it takes a quarter.
WHIRLS = 0.25
# Smallest eigenvalue of a modal stiffness, over the largest, of a body with free modes.
FREE_MODE = 1e-12
