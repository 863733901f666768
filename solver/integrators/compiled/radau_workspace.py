"""Coefficients and memory of the compiled step loop of Radau IIA."""

from typing import NamedTuple

import numpy as np

from ...dynamics.evaluation.evaluation import evaluate
from ...dynamics.model.model import Model
from ...dynamics.model.workspace import Work, new_work
from ...math.arrays import Array, IntArray
from ...math.compiled import structure
from .cutoff import Cutoff, new_cutoff
from .newton.elements import start_forces
from .newton.pencil import Frozen, Pencil, new_frozen, new_pencil
from .step_control import (
    ERROR_LAST,
    GROWTH,
    LIMIT,
    N_CLOCK,
    N_COUNT,
    NEXT,
    OTHER,
    RATE,
    ROUGH,
    SINCE,
    TAKEN,
    TIME,
)

ROOT = np.sqrt(6.0)
C = np.array([(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0])  # stages [h]
# Powers of a collocation polynomial that vanishes at 0, from its values at C: c_k of x^(k+1).
POWERS = np.linalg.inv(np.column_stack([C, C**2, C**3]))
# Stage equations z = h A f: A integrates the polynomial through f at C.
A = np.column_stack([C, C**2 / 2.0, C**3 / 3.0]) @ np.linalg.inv(np.vander(C, 3, increasing=True))
A_INVERSE = np.linalg.inv(A)


def _real_form() -> tuple[float, complex, np.ndarray, np.ndarray]:
    """Return mu, nu, T, T^-1 with T^-1 A^-1 T = [mu; Re nu, -Im nu; Im nu, Re nu]."""
    values, vectors = np.linalg.eig(np.linalg.inv(A))
    real = int(np.argmin(np.abs(values.imag)))
    pair = int(np.argmin(values.imag))
    T = np.column_stack([vectors[:, real].real, vectors[:, pair].real, vectors[:, pair].imag])
    # A^-1 (u + i v) = nu' (u + i v): w_1 + i w_2 is multiplied by the conjugate of nu'
    return float(values[real].real), complex(values[pair].conjugate()), T, np.linalg.inv(T)


MU, NU, T, T_INVERSE = _real_form()
# Embedded formula of order 3, times 1 / h: f_0 + ERROR z / h, then divided by mu / h - J.
ERROR = np.array([-13.0 - 7.0 * ROOT, -13.0 + 7.0 * ROOT, -1.0]) / 3.0


@structure
class RadauWorkspace(NamedTuple):
    """Memory of a run, which a call takes up where the last one left it."""

    work: Work
    frozen: Frozen
    real: Pencil
    pair: Pencil
    y: Array  # (n,) state
    f: Array  # (n,) its rate
    y_old: Array  # (n,) state at the beginning of the last step
    Q: Array  # (3, n) polynomial of the last step
    Z: Array  # (3, n) changes at the stages
    multipliers: Array  # (3, n_r) at the stages, by row of plan.newton
    multipliers_old: Array  # (3, n_r) at those of the last step
    predicted: Array  # (3, n_r) at the stages, before the iteration
    power: Array  # (3,) at the stages [W]
    load: Array  # (3, nb, n) residuals of the stages: forces,
    gamma: Array  # (3, n_r) constraints and laws of elements
    r: Array  # (3, n) and kinematics
    stage: Array  # (n,)
    rate: Array  # (n,) at a stage
    weight: Array  # (n,)
    cutoff: Cutoff
    least: Array  # (n_e,) stiffness that elements have had [N/m, N m/rad]
    damped: Array  # (1,) energy lost above the cutoff [J]
    clock: Array  # (N_CLOCK,)
    counts: IntArray  # (N_COUNT,)
    blamed: IntArray  # (n,) refusals that each component was the reason of
    apart: IntArray  # (N_COUNT,) of what is no part of a step: joints closed at output times


def new_radau_workspace(
    model: Model,
    t: float,
    y: Array,
    rate: Array,
    multipliers: Array,
    first_step: float,
) -> RadauWorkspace:
    """Return memory for a run from state y (n,) at t [s], with its rate and multipliers (n_c,)."""
    n, nb, widest = y.shape[0], model.n_body, model.plan.widest
    n_r = model.plan.newton.place.shape[0]
    frozen, least = new_frozen(model), np.full(model.plan.element_row.shape[0], np.inf)
    workspace = RadauWorkspace(
        new_work(model),
        frozen,
        new_pencil(model, 1.0),
        new_pencil(model, 1.0 + 0.0j),
        y.copy(),
        rate.copy(),
        y.copy(),
        np.zeros((3, n)),
        np.zeros((3, n)),
        np.zeros((3, n_r)),
        np.zeros((3, n_r)),
        np.zeros((3, n_r)),
        np.zeros(3),
        np.zeros((3, nb, widest)),
        np.zeros((3, n_r)),
        np.zeros((3, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        new_cutoff(model, frozen, least),
        least,
        np.zeros(1),
        np.zeros(N_CLOCK),
        np.zeros(N_COUNT, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros(N_COUNT, dtype=np.int64),
    )
    workspace.clock[TIME], workspace.clock[NEXT], workspace.clock[ERROR_LAST] = t, first_step, 1.0
    workspace.clock[LIMIT], workspace.clock[ROUGH], workspace.clock[GROWTH] = 1e300, 1e300, 1.0
    workspace.clock[SINCE], workspace.clock[OTHER] = t, np.inf
    restart_radau(model, workspace, t, y, rate, multipliers)
    return workspace


def restart_radau(
    model: Model, workspace: RadauWorkspace, t: float, y: Array, rate: Array, multipliers: Array
) -> None:
    """Forget what was before state y (n,) at t [s]; rate and multipliers are those after it."""
    workspace.y[:], workspace.f[:] = y, rate
    workspace.clock[TAKEN], workspace.clock[RATE] = 0.0, 1.0
    workspace.work.multipliers[:] = multipliers
    evaluate(model, workspace.work, t, y)
    for k in range(3):
        workspace.multipliers_old[k, : model.n_constraint] = multipliers
        start_forces(model, workspace.work, workspace.multipliers_old[k])
