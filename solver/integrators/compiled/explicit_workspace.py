"""Memory of a compiled step loop of an explicit Runge-Kutta method, and its tableau."""

from typing import NamedTuple

import numpy as np

from ...dynamics.model import Model
from ...dynamics.workspace import Work, new_work
from ...math.arrays import Array, IntArray
from ...math.compiled import structure
from .step_control import ERROR_LAST, N_CLOCK, N_COUNT, NEXT, TIME

# Entries of `clock` after those of every loop (step_control.py): whether the last attempt was
# refused, the beginning of the last step; steps in a row that look stiff and that do not, and the
# step at which they were so many that a hint is due; the largest step after one that was refused.
REFUSED_LAST, TIME_OLD, SUSPECT, CLEAR, STIFF_TIME, STIFF_STEP, LARGEST = 4, 5, 6, 7, 8, 9, 10


@structure
class ExplicitTableau(NamedTuple):
    """Numbers of a method; their meaning is that of generic/explicit.py."""

    A: Array  # (s, s)
    B: Array  # (s,)
    C: Array  # (s,)
    E: Array  # (1, s + 1) or (2, s) errors
    A_extra: Array  # (e, s + 1 + e) stages that only the dense output needs
    C_extra: Array  # (e,)
    D: Array  # (d, s + 1 + e) coefficients of the dense output
    exponent: float
    integral: float
    min_factor: float
    max_factor: float
    stability_limit: float
    first_same_as_last: bool


@structure
class ExplicitWorkspace(NamedTuple):
    """Memory of a run, which a call takes up where the last one left it."""

    work: Work
    K: Array  # (s + 1 + e, n) derivatives at the stages, the new state, the extra stages
    y: Array  # (n,) state
    f: Array  # (n,) its rate
    y_old: Array  # (n,) state at the beginning of the last step
    F: Array  # (d + 3 or d, n) polynomial of the last step
    y_new: Array  # (n,)
    point: Array  # (n,) the last stage's state
    error: Array  # (n,)
    weight: Array  # (n,)
    step: Array  # (n_vel,) of the projection
    before: Array  # (n_pos,)
    clock: Array  # (N_CLOCK,)
    counts: IntArray  # (N_COUNT,)


def new_explicit_workspace(
    model: Model, tableau: ExplicitTableau, t: float, y: Array, rate: Array, first_step: float
) -> ExplicitWorkspace:
    """Return memory for a run from state y (n,) at t [s], with its rate."""
    n, d = y.shape[0], tableau.D.shape[0]
    workspace = ExplicitWorkspace(
        new_work(model),
        np.zeros((tableau.D.shape[1], n)),
        y.copy(),
        rate.copy(),
        y.copy(),
        np.zeros((d if tableau.first_same_as_last else d + 3, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(model.n_vel),
        np.zeros(model.n_pos),
        np.zeros(N_CLOCK),
        np.zeros(N_COUNT, dtype=np.int64),
    )
    workspace.clock[TIME], workspace.clock[NEXT], workspace.clock[ERROR_LAST] = t, first_step, 1e-4
    workspace.clock[LARGEST] = 1e300
    return workspace
