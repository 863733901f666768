"""Forces of elements as unknowns of Newton's iteration, beside the multipliers of the constraints.

An element pushes with -g'(k e + c edot) (dynamics/elements/forces/contract.py). In Newton's
iteration F stands for k e + c edot, and k e + c edot - F = 0 is an equation of its own. Without it,
a stiff element would answer a small error of e with a large force, in a direction g that is not
exactly that of Newton's matrix: the iteration would diverge from some stiffness on, as the square
of the angle by which g turns in a step. With it, the limit of large k is the constraint e = 0 with
the multiplier F.
"""

from ....dynamics.elements.forces.table import element_rows
from ....dynamics.evaluation.evaluation import fill_jacobian
from ....dynamics.model.model import Model
from ....dynamics.model.workspace import DAMPING, FORCE, N_ELEMENT_ROW, STIFFNESS, Work
from ....math.arrays import Array
from ....math.compiled import inlined, lean


@inlined
def element_rows_at(model: Model, work: Work, e: int) -> int:
    """Fill work.element_used with the rows of element e at the last evaluation; return how many."""
    plan = model.plan
    begin, end = plan.element_start[e], plan.element_start[e + 1]
    if begin < end:
        along = model.quantities.along[e]
        if along >= 0:  # a force along a coordinate: -g'F with F = -size
            for j in range(12):
                work.element[0, j] = work.g[along, j]
            work.element[0, FORCE] = -work.size[e, 0]
            work.element[0, STIFFNESS] = max(0.0, -work.size[e, 1])
            work.element[0, DAMPING] = max(0.0, -work.size[e, 2])
        else:
            one = work.motion[model.force_marker[e, 0]]
            two = work.motion[model.force_marker[e, 1]]
            element_rows(model.force_kind[e], one, two, model.force_parameters[e], work.element)
        for k in range(begin, end):
            for j in range(N_ELEMENT_ROW):
                work.element_used[k - begin, j] = work.element[plan.element_row[k], j]
    return int(end - begin)


@lean
def freeze_elements(model: Model, work: Work, stiffness: Array, damping: Array, J: Array) -> None:
    """Fill stiffness and damping (n_e,) and the columns of elements in J (nb, n, r)."""
    plan = model.plan
    for e in range(model.force_kind.shape[0]):
        count, begin = element_rows_at(model, work, e), plan.element_start[e]
        for k in range(count):
            stiffness[begin + k] = work.element_used[k, STIFFNESS]
            damping[begin + k] = work.element_used[k, DAMPING]
        for side in range(2):
            first, marker = plan.element_side[e, side], model.force_marker[e, side]
            if first >= 0:
                body, rows = model.marker_body[marker], work.element_used[:count]
                J_m, n = work.J_m[marker], plan.size[body]
                fill_jacobian(J[body], first, rows, 6 * side, J_m, n)


@lean
def element_residual(model: Model, work: Work, forces: Array, load: Array, gamma: Array) -> None:
    """Replace the forces k e + c edot of the last evaluation in load (nb, n) by `forces`.

    Parameters
    ----------
    forces : (n_r,) by row of plan.newton; only those of elements are used
    gamma : (n_r,), of which elements: forces - (k e + c edot)
    """
    plan = model.plan
    first = model.n_constraint + plan.added_start[model.n_body]
    for e in range(model.force_kind.shape[0]):
        count, begin = element_rows_at(model, work, e), first + plan.element_start[e]
        for k in range(count):
            gamma[begin + k] = forces[begin + k] - work.element_used[k, FORCE]
        for side in range(2):
            marker = model.force_marker[e, side]
            body = model.marker_body[marker]
            if body >= 0 and count > 0:
                for j in range(6):
                    push = 0.0
                    for k in range(count):
                        push += work.element_used[k, 6 * side + j] * gamma[begin + k]
                    for b in range(plan.size[body]):
                        load[body, b] -= work.J_m[marker, j, b] * push


@lean
def start_forces(model: Model, work: Work, forces: Array) -> None:
    """Fill the entries of elements in forces (n_r,) with k e + c edot of the last evaluation."""
    first = model.n_constraint + model.plan.added_start[model.n_body]
    for e in range(model.force_kind.shape[0]):
        count, begin = element_rows_at(model, work, e), first + model.plan.element_start[e]
        for k in range(count):
            forces[begin + k] = work.element_used[k, FORCE]
