"""Limits of plans of runs and their checks, of derivatives of runs, and of modes about a state.

A line `Test:` names a test that fails if the value is ten times as large, or a tenth.
Values without one have no such test so far.
"""

# Of the accuracy asked for: estimate up to which a request counts as met.
REQUEST_MET = 0.9

# Of the accuracy: estimate up to which no further run shows what both packages lack. By `tail`, it
# is at most 1.6 times what the package of the model lacks, which is a part of the estimate.
SURELY_MET = 1.0 / 3.0

# What a check lacks, over its last change by the tolerance. Measured up to 1.4 in runs of four-bars
# and slider-cranks with tolerances that resolve the vibrations (docs/measurements.md).
# Test: tests/verification/test_fidelity.py::test_the_stated_error_of_a_joint_force_holds
# Test: tests/verification/test_fidelity.py::test_checks_of_small_deflections_end_where_two_agree
LACKING = 1.5

# Steps of a check over those of the last one, from which the difference of both shows an error.
# The tolerance gives 3^(1/4); this is half of it, 3^(1/8).
# Test: tests/verification/test_fidelity.py::test_checks_of_a_joint_force_differ_in_their_steps
MORE_STEPS = 1.15

# CPU time of a check over that of the last one of three times its tolerance: steps are proportional
# to 1 / tolerance where it decides which vibrations are resolved (four-bars: 1.5 to 3.2).
# Test: tests/verification/test_fidelity.py::
# test_all_modes_are_the_model_where_the_budget_does_not_split_an_error
LADDER_COST = 3.0

# Of the budget that is left, for all runs that split an error by its sources.
SPLIT_COST = 0.5

# Of the accuracy: loss of all modes that are left out, and loss from which stiffening is on.
OMITTED_SHARE = 0.5
STIFFENING_SHARE = 0.25

# Of the first clamped frequency: spin from which stiffening is on.
STIFFENING_SPIN = 0.5

# Damped static shapes damp the vibrations that joints couple them with: a frequency changes by
# little, but the phase by more with every period. The indicators take modes one by one.
DAMPED_ABOVE = 3e-4

# Of the tolerance times the largest force, relative: planar pendulums have forces across their
# plane of 0.2 to 1.5 times that, which a tighter tolerance removes.
FORCE_NOISE = 3.0

# Range of the tolerance of a plan: small deflections need the first, as errors are of their size.
LEAST_RTOL = 1e-9
MOST_RTOL = 1e-3

# Root of the strain energy of a mode that does not respond, over the largest.
FAINT = 1e-8

# Of the largest share of the error, from which a kind of mode is promoted.
# Test: tests/unit/test_fidelity_promotion.py::
# test_what_exceeds_the_accuracy_is_promoted_with_what_exceeds_it_more
PROMOTED = 0.3

# Indicated cost that is not printed.
NO_COST = 1e-9

# Forward differences of the terms of a tangent: their error, and that of round-off, are near 1e-8
# of the largest term.
STEP = 3e-8

# Least part of this step, near a bend of a force. A step that ends this near a bend ends at it.
# Test: tests/verification/test_sensitivities.py::test_a_ball_dropped_on_a_hard_stop
LEAST_STEP = 1e-2

# Of dependent coordinates over independent ones, by inertia: others are independent sooner.
MOST_GROWTH = 1e4

# Modes about a state: accelerations of turned positions that are zero [1/s2]; those of a state that
# is called an equilibrium, of those by loads; change of the equations in turned positions, over the
# eigenvalues, that counts as none.
TURNS_FREELY = 1e-6
AT_REST = 1e-6
CONSTANT_EQUATIONS = 1e-5

# Elastic rotation of an interface [rad], and estimated error of differences, without a note.
BENT = 0.03
ACCURATE_DIFFERENCES = 1e-4

# Campbell diagrams: overlap of shapes below which a mode has no successor at the next speed, and
# below which the step is halved; damping ratio above which a motion is gone within one period;
# accuracy of the speed of a crossing, relative.
LEAST_OVERLAP = 0.1
ALIKE_OVERLAP = 0.8
OVERDAMPED = 0.99
CROSSING_FOUND = 1e-7

# Entry of a section over the root of the product of its diagonal entries: rounding, as both DOLFINx
# agree to it.
# Test: tests/unit/test_design.py::test_an_entry_that_symmetry_makes_zero_is_zero
NO_COUPLING = 1e-9

# Change of an objective that is none, relative: by other designs, and by its derivatives over the
# range of a parameter.
# Test: tests/unit/test_design.py::test_an_objective_that_depends_on_nothing_is_named
SAME_OBJECTIVE = 1e-9
