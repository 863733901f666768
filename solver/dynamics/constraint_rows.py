"""Rows of joints and couplings, and the constraint Jacobian of each body."""

from ..math.arrays import Array
from ..math.compiled import inlined, lean
from .joints.table import joint_rows
from .laws import law_at
from .measures import acceleration_of
from .model import Model
from .workspace import GAMMA, PHI, Work


@inlined
def evaluate_joints(model: Model, work: Work, t: float) -> None:
    """Fill the rows of all joints and the Jacobians at the bodies."""
    rows, plan = work.rows, model.plan
    for k in range(model.joint_kind.shape[0] - n_coupling(model)):
        one = work.motion[model.joint_marker[k, 0]]
        two = work.motion[model.joint_marker[k, 1]]
        begin, end = model.joint_row[k], model.joint_row[k + 1]
        drive, drive_d, drive_dd = 0.0, 0.0, 0.0
        if model.joint_law[k] >= 0:
            drive, drive_d, drive_dd = law_at(model, model.joint_law[k], t)
        joint_rows(
            rows,
            begin,
            model.joint_kind[k],
            one,
            two,
            drive,
            drive_d,
            drive_dd,
            model.joint_parameters[k],
        )
        for side in range(2):
            body = model.marker_body[model.joint_marker[k, side]]
            if body >= 0:
                first, n = plan.side_row[k, side], plan.size[body]
                J_m = work.J_m[model.joint_marker[k, side]]
                fill_jacobian(work.J[body], first, rows[begin:end], 6 * side, J_m, n)


@inlined
def n_coupling(model: Model) -> int:
    """Return how many of the joints, the last ones, are couplings of coordinates."""
    return int(model.quantities.coupling_start.shape[0] - 1)


@lean
def evaluate_couplings(model: Model, work: Work) -> None:
    """Fill the rows of couplings, sum r e = 0, and their columns of the Jacobians.

    The coefficients C of a row are those of its first coordinate.
    """
    q, plan, rows = model.quantities, model.plan, work.rows
    first = model.joint_kind.shape[0] - n_coupling(model)
    for c in range(n_coupling(model)):
        row, begin, end = model.joint_row[first + c], q.coupling_start[c], q.coupling_start[c + 1]
        for j in range(rows.shape[1]):
            rows[row, j] = 0.0
        for term in range(begin, end):
            m = q.coupling_coordinate[term]
            for side in range(2):
                column, body = (
                    plan.coupling_column[term, side],
                    model.marker_body[q.marker[m, side]],
                )
                if column >= 0:
                    for b in range(plan.size[body]):
                        work.J[body, b, column] = 0.0
        for term in range(begin, end):
            m, r = q.coupling_coordinate[term], q.coupling_ratio[term]
            one, two = work.motion[q.marker[m, 0]], work.motion[q.marker[m, 1]]
            rows[row, PHI] += r * work.quantity[2 * m]
            rows[row, GAMMA] -= r * acceleration_of(q.kind[m], q.axes[m], one, two)
            if term == begin:
                for j in range(12):
                    rows[row, j] = r * work.g[m, j]
            for side in range(2):
                column, marker = plan.coupling_column[term, side], q.marker[m, side]
                if column >= 0:
                    body = model.marker_body[marker]
                    for b in range(plan.size[body]):
                        for a in range(6):
                            push = r * work.g[m, 6 * side + a]
                            work.J[body, b, column] += push * work.J_m[marker, a, b]


@inlined
def fill_jacobian(J: Array, first: int, C: Array, begin: int, J_m: Array, n: int) -> None:
    """J (n, r) from column `first`: C of one side times the marker's Jacobian, transposed.

    Most rows hold either a displacement or a rotation: the other half of their product is zero.
    """
    for p in range(C.shape[0]):
        v0, v1, v2 = C[p, begin], C[p, begin + 1], C[p, begin + 2]
        w0, w1, w2 = C[p, begin + 3], C[p, begin + 4], C[p, begin + 5]
        column = first + p
        if w0 == 0.0 and w1 == 0.0 and w2 == 0.0:
            for j in range(n):
                J[j, column] = v0 * J_m[0, j] + v1 * J_m[1, j] + v2 * J_m[2, j]
        elif v0 == 0.0 and v1 == 0.0 and v2 == 0.0:
            for j in range(n):
                J[j, column] = w0 * J_m[3, j] + w1 * J_m[4, j] + w2 * J_m[5, j]
        else:
            for j in range(n):
                J[j, column] = (
                    v0 * J_m[0, j]
                    + v1 * J_m[1, j]
                    + v2 * J_m[2, j]
                    + w0 * J_m[3, j]
                    + w1 * J_m[4, j]
                    + w2 * J_m[5, j]
                )
