"""Joint reactions, and their balance with the change of momentum."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..math.arrays import Array
from ..math.rotations import rotation_matrix
from .bodies.marker import marker_motion, single_motion
from .bodies.motion import place
from .bodies.second_order import second_order_first_moment
from .forces.table import FIRST_LOAD, element_wrench
from .model import GROUND, Model
from .system import accelerations, assemble, derivative, law_at

# Central differences, exact for polynomials up to the sixth degree.
DIFFERENCE = ((-3, -1 / 60), (-2, 3 / 20), (-1, -3 / 4), (1, 3 / 4), (2, -3 / 20), (3, 1 / 60))


def joint_reactions(model: Model, t: float, y: Array, multipliers: Array) -> Array:
    """Return force [N] and moment [N m] of each joint on its two sides, (nj, 2, 6).

    Global components; the moment is about the origin of that side's marker. They are
    -C' lambda with the coefficients C of the joint's rows, which do the same
    virtual work. For redundant joints they are those of least norm.
    """
    return _joint_reactions(model, assemble(model, t, y).C, multipliers)


def marker_loads(
    model: Model, t: float, y: Array, C: Array, multipliers: Array
) -> Iterator[tuple[int, Array, Array]]:
    """Marker, force (3,) and moment (3,) at its origin on its body, of joints and force elements.

    Global components [N, N m]. The step loop adds the same in its own rows (dynamics/system.py).

    Parameters
    ----------
    C : coefficients of the joints' rows in state y (`Equations`)
    """
    for markers, both in zip(
        model.joint_marker, _joint_reactions(model, C, multipliers), strict=True
    ):
        for marker, load in zip(markers, both, strict=True):
            yield int(marker), load[:3], load[3:]
    for k in range(model.force_kind.size):
        one, two = (single_motion(model, marker, y)[0] for marker in model.force_marker[k])
        size = law_at(model, model.force_law[k], t)[0]
        wrench = element_wrench(model.force_kind[k], one, two, model.force_parameters[k], size)
        force, moment = np.array(wrench.force), np.array(wrench.moment)
        yield int(model.force_marker[k, 1]), force, moment
        if model.force_kind[k] < FIRST_LOAD:
            arm = np.subtract(place(two), place(one))
            yield int(model.force_marker[k, 0]), -force, -moment - np.cross(arm, force)


def _joint_reactions(model: Model, C: Array, multipliers: Array) -> Array:
    found = np.zeros((model.joint_kind.size, 2, 6))
    for k in range(model.joint_kind.size):
        rows = slice(int(model.joint_row[k]), int(model.joint_row[k + 1]))
        found[k] = -(C[rows].T @ multipliers[rows]).reshape(2, 6)
    return found


def momenta(model: Model, t: float, y: Array) -> Array:
    """Return linear momentum and angular momentum about the global origin, (nb, 6).

    They follow from the mass matrix alone; point masses belong to the bodies that carry them.
    """
    p = assemble(model, t, y).M @ y[model.n_pos : model.n_pos + model.n_vel]
    found = np.zeros((model.n_body, 6))
    for i in range(model.n_body):
        a, j = int(model.pos_start[i]), int(model.vel_start[i])
        A = rotation_matrix(y[a + 3 : a + 7])
        found[i, :3] = p[j : j + 3]
        found[i, 3:] = np.cross(y[a : a + 3], p[j : j + 3]) + A @ p[j + 3 : j + 6]
    return found


def momentum_rates(model: Model, t: float, y: Array) -> Array:
    """Return the rates of `momenta` along the solution, (nb, 6), by finite differences.

    They depend on forces and multipliers only through the accelerations. All
    coordinates are moved along their rates. Momenta are polynomials of low degree in them, except
    for the norm of the Euler parameters, and a body rotates by thousandths of a radian.
    """
    rate = derivative(model, t, y)
    turning = 0.0
    for i in range(model.n_body):
        a = int(model.pos_start[i]) + 3
        turning = max(turning, float(np.linalg.norm(rate[a : a + 4])))
    h = 2e-3 / max(turning, 1.0)
    return np.asarray(
        sum(weight * momenta(model, t, y + s * h * rate) for s, weight in DIFFERENCE) / h
    )


def _add(total: Array, scale: Array, body: int, x: Array, force: Array, moment: Array) -> None:
    """Add a force at x and a moment to a body, about the global origin."""
    if body != GROUND:
        wrench = np.concatenate([force, np.cross(x, force) + moment])
        total[body] += wrench
        scale[body] += np.abs(wrench)


def acting(model: Model, t: float, y: Array, multipliers: Array) -> tuple[Array, Array]:
    """Return resultants about the global origin of all forces on each body, (nb, 6).

    Also returns the sum of their absolute values (nb, 6), as scale of an error. The forces are
    weight, force elements, loads and reactions.
    """
    total, scale = np.zeros((model.n_body, 6)), np.zeros((model.n_body, 6))
    nothing = np.zeros(3)
    for i in range(model.n_body):
        a, m = int(model.pos_start[i]), int(model.n_mode[i])
        one = int(model.mode_start[i])
        S = model.S[3 * one : 3 * (one + m)].reshape(3, m)
        q = y[a + 7 : a + 7 + m]
        first = model.S0[i] + S @ q
        if model.second_start[i + 1] > model.second_start[i]:
            first = first + second_order_first_moment(model, i, q)
        arm = model.mass[i] * y[a : a + 3] + rotation_matrix(y[a + 3 : a + 7]) @ first
        weight = model.mass[i] * model.gravity_G
        _add(total, scale, i, nothing, weight, np.cross(arm, model.gravity_G))
    C = assemble(model, t, y).C
    for marker, force, moment in marker_loads(model, t, y, C, multipliers):
        x = marker_motion(model, marker, y).x
        _add(total, scale, model.marker_body[marker], x, force, moment)
    return total, scale


@dataclass(frozen=True)
class MomentumBalance:
    """Error of d(momentum)/dt = sum of loads and reactions, over the largest term in the run."""

    linear: float
    angular: float


def momentum_balance(model: Model, t: Array, y: Array) -> MomentumBalance:
    """Compare forces with the change of momentum for each body at states y (k, n)."""
    errors, scales = np.zeros((t.size, 2)), np.zeros((t.size, 2))
    for k in range(t.size):
        _, multipliers = accelerations(model, assemble(model, t[k], y[k]), y[k])
        total, scale = acting(model, t[k], y[k], multipliers)
        error = np.abs(momentum_rates(model, t[k], y[k]) - total)
        errors[k] = error[:, :3].max(), error[:, 3:].max()
        scales[k] = scale[:, :3].max(), scale[:, 3:].max()
    relative = errors.max(axis=0) / np.maximum(scales.max(axis=0), 1e-300)
    return MomentumBalance(float(relative[0]), float(relative[1]))
