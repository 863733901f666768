"""Tolerances of the start of a mechanism: closed joints, equilibrium, static shapes.

A line `Test:` names a test that fails if the value is ten times as large, or a tenth.
Values without one have no such test so far.
"""

# Second-order tables below this fraction of the others are round-off: in-plane bending moves no
# station out of the plane.
NO_SECOND_ORDER = 1e-12

# Mass of a point mass over that of its body, from which on it becomes a virtual body.
HEAVY_POINT_MASS = 1e3

# Residual of the positions with closed joints [rad; distances over the size of the mechanism].
# Joints that stay open by more than the second cannot be closed.
POSITION_TOLERANCE = 1e-12
STAYS_OPEN = 1e3 * POSITION_TOLERANCE

# Sine of the angle between axes of hinges, and distance of their lines [m], that are one line.
ONE_LINE = 1e-9

# Residual of the velocities, relative to the largest.
VELOCITY_TOLERANCE = 1e-9

# Singular value of the scaled Jacobian over the largest, below which a loop is nearly movable; the
# next one is larger by this factor at least.
# Test: tests/verification/test_locked_loops.py::test_a_loop_that_is_clearly_locked_stands_still
NEARLY_MOVABLE = 3e-3
WEAK_APART = 20.0

# Gap of a motion that is tried over that of the first order: larger in a singular position only.
# Test: tests/verification/test_locked_loops.py::test_a_loop_that_is_locked_by_little_is_refused
STAYS_CLOSED = 3.0

# Last change of that motion over the first, in Newton's iteration.
MOTION_CONVERGED = 1e-12

# Speed of a drive that stands still [m/s, rad/s].
DRIVE_AT_REST = 1e-12

# Unbalanced accelerations in equilibrium, relative to the largest due to the loads; and residual of
# the positions there [rad; distances over the size of the mechanism].
BALANCED = 1e-10
BALANCE_CLOSED = 1e-12

# Unbalanced forces over the least of the steps before; above it a step has brought nothing.
FALLS = 0.99

# Stiffness over inertia that counts as zero [1/s2]: a period of 100 minutes.
NEUTRAL = 1e-6

# Change of the loads in turned positions that counts as none, relative to the loads.
CONSTANT_LOADS = 1e-6

# Velocities that joints contradict, relative to the largest, in steady spin.
SPIN_CONSISTENT = 1e-9

# Of the spin: least step of the continuation from rest.
LEAST_SPIN_STEP = 1.0 / 256.0

# Rate of a drive against the steady spin, relative.
DRIVE_CONTRADICTS = 1e-9

# Quasi-static start: change of the shapes in the norm of the strain energy that ends the iteration,
# energy of a change over that of the first that tells divergence, strain energy over that of the
# first change and displacement over the size that are round-off.
SHAPES_SETTLED = 1e-8
SHAPES_DIVERGED = 1e8
NO_STRAIN_ENERGY = 1e-20
NO_DISPLACEMENT = 1e-13

# Change of the rates of the shapes within a tenth of the slowest period over 2 pi, of the rates.
# Motions of a third of the first frequency: 0.03. Loads that begin or end within it: 1.
# Test: tests/verification/test_quasi_static_start.py::test_rates_that_do_not_last_are_not_followed
RATES_LAST = 0.5
