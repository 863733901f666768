"""Tolerances of the iteration of generic integrators."""

# With an old matrix: rate of convergence that tells a bend of f behind which all corrections are
# far too small, and least correction, in tolerances, that is no rounding.
SLOW = 0.9
ROUNDED = 1e-6
