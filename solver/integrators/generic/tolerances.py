"""Tolerances of the iteration of generic integrators."""

# Newton's iteration with an old matrix, behind a bend of f: its corrections are far too small if
# they decrease by a rate above SLOW. Corrections below ROUNDED tolerances are rounding.
SLOW = 0.9
ROUNDED = 1e-6
