"""Equations of motion of the whole system and their solution for accelerations."""

from typing import NamedTuple

import numpy as np

from .bodies.floating_frame import add_inertia
from .bodies.marker import Marker, marker_motion, standing_marker
from .bodies.second_order import add_second_order, second_order_first_moment, second_order_of
from .compiled import jit
from .constraints.augmented_lagrangian import augmented_lagrangian
from .constraints.baumgarte import stabilised
from .constraints.minimum_norm import minimum_norm
from .constraints.saddle_point import saddle_point
from .coordinates import position_rates
from .forces.point_mass import add_point_mass
from .forces.table import FIRST_LOAD, element_wrench
from .joints.rows import Rows
from .joints.table import joint_rows
from .laws import law_value
from .model import Model
from .package.schema import Array
from .rotations import cross, rotation_matrix
from .small import add, mm, mv, tv


class Equations(NamedTuple):
    """One evaluation of the equations of motion at (t, y)."""

    M: Array  # (n_vel, n_vel) mass matrix
    f: Array  # (n_vel,) loads, quadratic velocity terms, elastic and damping forces
    Phi_q: Array  # (n_c, n_vel) d Phidot / d velocities
    C: Array  # (n_c, 12) the same by the velocities of each joint's two markers (joints/rows.py)
    Phi: Array  # (n_c,)
    Phi_t: Array  # (n_c,)
    gamma: Array  # (n_c,) gamma* of Eq. (11)
    power: Array  # (1,) of dampers, actuators and loads [W]
    potential: Array  # (1,) energy stored in force elements [J]


@jit
def assemble(model: Model, t: float, y: Array) -> Equations:
    """Assemble mass matrix, forces and constraints at time t and state y.

    Paper: Eq. (5), Eq. (6), Eq. (8), Eq. (9), Eq. (12) with the sign of s of Eq. (6):
    M a + Phi_q' lambda = f.
    """
    n_vel, n_c = model.n_vel, model.n_constraint
    M = np.zeros((n_vel, n_vel))
    f = np.zeros(n_vel)
    power, potential = np.zeros(1), np.zeros(1)
    for i in range(model.n_body):
        _add_body(model, i, y, M, f, power)
    for k in range(model.point_mass.shape[0]):
        marker = marker_motion(model, model.point_marker[k], y)
        body = model.marker_body[model.point_marker[k]]
        if body >= 0:
            j = model.vel_start[body]
            e = j + 6 + model.n_mode[body]
            add_point_mass(M[j:e, j:e], f[j:e], marker, model.point_mass[k], model.gravity_G)
    _add_forces(model, t, y, f, power, potential)

    Phi_q = np.zeros((n_c, n_vel))
    rows = Rows(np.zeros(n_c), np.zeros((n_c, 12)), np.zeros(n_c), np.zeros(n_c))
    one = two = standing_marker(np.zeros(3), np.eye(3))
    for k in range(model.joint_kind.shape[0]):
        if k == 0 or not _same_markers(model, k):  # a drive stands on its joint's markers
            one = marker_motion(model, model.joint_marker[k, 0], y)
            two = marker_motion(model, model.joint_marker[k, 1], y)
        a, b = model.joint_row[k], model.joint_row[k + 1]
        drive, drive_d, drive_dd = law_at(model, model.joint_law[k], t)
        length = model.joint_length[k]
        joint_rows(rows, a, model.joint_kind[k], one, two, drive, drive_d, drive_dd, length)
        for side in range(2):
            marker = one if side == 0 else two
            body = model.marker_body[model.joint_marker[k, side]]
            if body >= 0:
                j = model.vel_start[body]
                C = rows.C[a:b, 6 * side : 6 * side + 6]
                add(Phi_q, a, j, mm(C[:, :3], marker.J_v), 1.0)
                add(Phi_q, a, j, mm(C[:, 3:], marker.J_w), 1.0)
    return Equations(M, f, Phi_q, rows.C, rows.Phi, rows.Phi_t, rows.gamma, power, potential)


@jit
def law_at(model: Model, law: int, t: float) -> tuple[float, float, float]:
    """Value and rates of a law at t; zeros where there is none."""
    if law < 0:
        return 0.0, 0.0, 0.0
    return law_value(model.law_start, model.law_time, model.law_coefficient, law, t)


@jit
def _add_forces(model: Model, t: float, y: Array, f: Array, power: Array, potential: Array) -> None:
    """Add the force elements to f (n_vel,), their power and their stored energy."""
    for k in range(model.force_kind.shape[0]):
        one = marker_motion(model, model.force_marker[k, 0], y)
        two = marker_motion(model, model.force_marker[k, 1], y)
        size, _, _ = law_at(model, model.force_law[k], t)
        wrench = element_wrench(model.force_kind[k], one, two, model.force_parameters[k], size)
        power[0] += wrench.power
        potential[0] += wrench.potential
        _push(model, model.force_marker[k, 1], two, f, wrench.force, wrench.moment)
        if model.force_kind[k] < FIRST_LOAD:
            moment = -wrench.moment - cross(two.x - one.x, wrench.force)
            _push(model, model.force_marker[k, 0], one, f, -wrench.force, moment)


@jit
def _push(model: Model, k: int, marker: Marker, f: Array, force: Array, moment: Array) -> None:
    """Add force and moment (3,), global, at marker k to f."""
    body = model.marker_body[k]
    if body < 0:
        return
    j = model.vel_start[body]
    by_force, by_moment = tv(marker.J_v, force), tv(marker.J_w, moment)
    for i in range(by_force.shape[0]):
        f[j + i] += by_force[i] + by_moment[i]


@jit
def _same_markers(model: Model, k: int) -> bool:
    """Tell whether joint k stands on the markers of joint k - 1."""
    here, before = model.joint_marker[k], model.joint_marker[k - 1]
    return bool(here[0] == before[0] and here[1] == before[1])


@jit
def _add_body(model: Model, i: int, y: Array, M: Array, f: Array, power: Array) -> None:
    """Add the inertia, gravity and modal forces of body i. Paper: Eq. (3), Eq. (4), Eq. (6)."""
    m = model.n_mode[i]
    a = model.pos_start[i]
    j = model.vel_start[i]
    c = model.n_pos + j
    one = model.mode_start[i]
    two = model.square_start[i]
    q = y[a + 7 : a + 7 + m]
    q_d = y[c + 6 : c + 6 + m]
    e = j + 6 + m
    add_inertia(
        M[j:e, j:e],
        f[j:e],
        rotation_matrix(y[a + 3 : a + 7]),
        y[c + 3 : c + 6],
        q,
        q_d,
        model.gravity_G,
        model.mass[i],
        model.S0[i],
        model.S[3 * one : 3 * (one + m)].reshape(3, m),
        model.T00[i],
        model.T01[9 * one : 9 * (one + m)].reshape(9, m),
        model.T11[9 * two : 9 * (two + m * m)].reshape(9 * m, m),
        model.J0[i],
        model.J_psi[3 * one : 3 * (one + m)].reshape(3, m),
        model.M_qq[two : two + m * m].reshape(m, m),
    )
    if model.second_start[i + 1] > model.second_start[i]:
        Z, G3, G4 = second_order_of(model, i)
        work = np.empty(12 * m + 36)
        A_GB, w = rotation_matrix(y[a + 3 : a + 7]), y[c + 3 : c + 6]
        M_i, f_i = M[j:e, j:e], f[j:e]
        add_second_order(M_i, f_i, A_GB, w, q, q_d, model.gravity_G, Z, G3, G4, work)
    damping = mv(model.D_qq[two : two + m * m].reshape(m, m), q_d)
    spring = mv(model.K_qq[two : two + m * m].reshape(m, m), q)
    for k in range(m):
        f[j + 6 + k] -= spring[k] + damping[k]
        power[0] -= q_d[k] * damping[k]


@jit
def constraint_rates(model: Model, equations: Equations, y: Array) -> Array:
    """Return Phidot (n_c,) in state y, of which `equations` are."""
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    return mv(equations.Phi_q, velocities) + equations.Phi_t


@jit
def respond(model: Model, equations: Equations, f: Array, gamma: Array) -> tuple[Array, Array]:
    """Return what answers f (n_vel,) and gamma (n_c,): accelerations and multipliers.

    M a + Phi_q' lambda = f and Phi_q a = gamma, in the way of the model's treatment. Impulses
    and small motions answer in the same way as accelerations: projections come here as well.
    """
    if model.penalty > 0.0 and model.n_constraint > 0:
        return augmented_lagrangian(
            equations.M,
            f,
            equations.Phi_q,
            gamma,
            model.inertia_scale,
            model.penalty,
            model.multiplier_tolerance,
            model.multiplier_iterations,
        )
    if model.redundant > 0:
        return minimum_norm(
            equations.M, f, equations.Phi_q, gamma, model.inertia_scale, model.redundant
        )
    return saddle_point(equations.M, f, equations.Phi_q, gamma)


@jit
def accelerations(model: Model, equations: Equations, y: Array) -> tuple[Array, Array]:
    """Return accelerations (n_vel,) and multipliers (n_c,) in state y. Paper: Eq. (13), Eq. (14).

    The multipliers of constraint i push with -Phi_q[i] lambda_i. Those of redundant
    constraints are the ones of least norm.
    """
    Phi_d = constraint_rates(model, equations, y)
    gamma = stabilised(equations.gamma, equations.Phi, Phi_d, model.alpha, model.beta)
    return respond(model, equations, equations.f, gamma)


@jit
def derivative(model: Model, t: float, y: Array) -> Array:
    """Return dy/dt, (n,): the index-1 system. Paper: Eq. (14).

    The last entry is the power of drives and dampers, so that the energy
    balance is integrated as accurately as the motion.
    """
    n_pos, n_vel = model.n_pos, model.n_vel
    equations = assemble(model, t, y)
    acceleration, multipliers = accelerations(model, equations, y)
    y_d = np.empty(y.shape[0])
    y_d[:n_pos] = position_rates(model, y[:n_pos], y[n_pos : n_pos + n_vel])
    y_d[n_pos : n_pos + n_vel] = acceleration
    y_d[n_pos + n_vel] = multipliers @ equations.Phi_t + equations.power[0]
    return y_d


@jit
def energies(model: Model, equations: Equations, y: Array) -> Array:
    """Return kinetic, strain and potential energy, (3,) [J]. Paper: Eq. (1), Eq. (3).

    `equations` are those of state y.

    Potential energy is that of weight, zero for a mass point at the global origin, and of springs.
    """
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    out = np.zeros(3)
    out[2] = equations.potential[0]
    out[0] = 0.5 * velocities @ (equations.M @ velocities)
    for i in range(model.n_body):
        a = model.pos_start[i]
        m = model.n_mode[i]
        one = model.mode_start[i]
        two = model.square_start[i]
        q = y[a + 7 : a + 7 + m]
        out[1] += 0.5 * q @ (model.K_qq[two : two + m * m].reshape(m, m) @ q)
        first = model.S0[i] + model.S[3 * one : 3 * (one + m)].reshape(3, m) @ q
        if model.second_start[i + 1] > model.second_start[i]:
            first += second_order_first_moment(second_order_of(model, i)[0], q)
        centre = model.mass[i] * y[a : a + 3] + rotation_matrix(y[a + 3 : a + 7]) @ first
        out[2] -= model.gravity_G @ centre
    for k in range(model.point_mass.shape[0]):
        marker = marker_motion(model, model.point_marker[k], y)
        out[2] -= model.point_mass[k] * (model.gravity_G @ marker.x)
    return out
