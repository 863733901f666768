"""Evaluation of the equations of motion: mass matrices, forces and constraints in one state."""

from ..math.arrays import Array
from ..math.compiled import inlined, lean
from .applied_forces import add_forces
from .block_vectors import inflate, largest, row_products
from .bodies.floating_frame import evaluate_bodies
from .bodies.marker import evaluate_markers
from .constraint_rows import evaluate_couplings, evaluate_joints
from .measures import auxiliary_rate, measure
from .model import Model
from .settling import reactions_into
from .workspace import PHI, PHI_T, Work


@lean
def evaluate(model: Model, work: Work, t: float, y: Array) -> None:
    """Fill mass matrices, forces and constraints at time t and state y; nothing is allocated.

    Forces that read reactions are those at work.multipliers.

    Paper: Eq. (5), Eq. (6), Eq. (8), Eq. (9), Eq. (12) with the sign of s of Eq. (6):
    M a + Phi_q' lambda = f.
    """
    work.power[0] = work.power[1] = 0.0
    evaluate_bodies(model, work, y)
    evaluate_markers(model, work, y)
    measure_into(model, work, y)
    evaluate_joints(model, work, t)
    if model.quantities.coupling_ratio.shape[0] > 0:
        evaluate_couplings(model, work)
    if reads_reactions(model):
        reactions_into(model, work)
    add_forces(model, work, t)


@inlined
def reads_reactions(model: Model) -> bool:
    """Tell whether forces or states read the reactions of joints."""
    return bool(model.quantities.reaction_kind.shape[0] > 0)


@inlined
def measure_into(model: Model, work: Work, y: Array) -> None:
    """Fill the quantities that expressions read, in state y with these markers."""
    if work.quantity.shape[0] > 0:
        first = model.n_pos + model.n_vel
        measure(model.quantities, work.motion, y, first, work.quantity, work.g)


@inlined
def auxiliary_rates_into(model: Model, work: Work, t: float, out: Array) -> None:
    """Fill the rates of the auxiliary states of the last evaluation in out (n,)."""
    first = model.n_pos + model.n_vel
    for j in range(model.n_aux):
        out[first + j], _ = auxiliary_rate(model.quantities, j, t, work.quantity)


@inlined
def largest_left(model: Model, work: Work, J: Array, x: Array) -> float:
    """Largest row of Phi + Phi_q x: above round-off if rows contradict each other."""
    row_products(model, J, x, work.left)
    for k in range(model.n_constraint):
        work.left[k] += work.rows[k, PHI]
    return largest(work.left)


@inlined
def evaluate_rates(model: Model, work: Work, y: Array) -> None:
    """Fill work.left with Phidot (n_c,) in state y, of the last evaluation."""
    inflate(model, y, model.n_pos, work.acceleration)
    row_products(model, work.J, work.acceleration, work.left)
    for k in range(model.n_constraint):
        work.left[k] += work.rows[k, PHI_T]
