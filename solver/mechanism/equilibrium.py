"""Static equilibrium, and relative equilibrium in steady spin about a fixed axis.

Newton's method for positions and multipliers: Z'(f - Phi_q' lambda) = 0 and Phi = 0, where the
columns of Z span the null space of Phi_q. Joints close together with the forces, and multipliers
are those of the linear step: if joints were closed after each step, slender bodies would be
stretched, and the forces of that would hide their stiffness in bending.

At rest, if these steps do not come to an end, the joints are closed after each step, and the step
reduces the potential energy, also if the stiffness has a negative eigenvalue. The search ends in a
minimum, not in an unstable equilibrium. Following loads have no potential; for them, the work along
the step is used.
"""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.analysis.rank import FreeMotions, free_motions
from ..dynamics.analysis.recovery import extent, sizes_of_motion
from ..dynamics.elements.joints.table import DRIVES, JOINTS, NAMES
from ..dynamics.evaluation.accelerations import Equations, assemble
from ..dynamics.evaluation.instants import started
from ..dynamics.evaluation.laws import law_values, with_laws
from ..dynamics.model.coordinates import Spin, moved, spin_accelerations, spin_velocities, turned
from ..dynamics.model.model import GROUND, Model
from ..errors import InputError, few
from ..math.arrays import Array
from .built_mechanism import BuiltMechanism, Start
from .consistent import row_sizes
from .tolerances import (
    BALANCE_CLOSED,
    BALANCED,
    CONSTANT_LOADS,
    FALLS,
    LEAST_SPIN_STEP,
    NEUTRAL,
    ONE_LINE,
    SPIN_CONSISTENT,
)

if TYPE_CHECKING:
    from ..inputs.case.tables.solver import Solver


_MAX_STEP = 0.3  # of `sizes_of_motion`
_MAX_ITERATIONS = 200
_PATIENT = 30  # steps in a row without progress; loads of the wind have no minimum
_REST = Spin(np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0)
_NUDGE = 0.05  # step away from an unstable equilibrium, of `sizes_of_motion`
_DIFFERENCE = 1e-6  # increment for the stiffness by finite differences, of `sizes_of_motion`


def resting_state(model: Model, start: Start, body_names: list[str]) -> tuple[Model, Array]:
    """Return the state y (n,) at rest in static equilibrium, and the model with laws that hold it.

    Drives and loads keep what they have at t = 0.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    start : positions and velocities at the start, as the case gives them
    body_names : names of the bodies of the model, for messages

    Raises
    ------
    InputError
        As `equilibrium`.
    """
    state = equilibrium(model, start, body_names)
    values = law_values(model, 0.0)
    values[:, 1:] = 0.0
    still = with_laws(model, 0.0, values)
    return still, started(still, 0.0, resting(model, state.positions, np.zeros(model.n_vel)))


def equilibrium(model: Model, start: Start, body_names: list[str]) -> Start:
    """Return the start with positions of static equilibrium; velocities do not change.

    Gravity, springs, bushings and loads have their values at the start, t = 0; drives keep
    their positions then.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    start : positions and velocities at the start, as the case gives them
    body_names : names of the bodies of the model, for messages

    Raises
    ------
    InputError
        No equilibrium found, or joints cannot be closed; names the body with unbalanced forces.
    """
    positions = closed(model, start.positions)
    balanced, _ = _newton(model, positions, _REST, stable=True)
    if balanced is not None:
        return start._replace(positions=balanced)
    sizes = sizes_of_motion(model, _size(model, positions))
    largest, least, stalled, steps = 0.0, np.inf, 0, 0
    while stalled < _PATIENT and steps < _MAX_ITERATIONS:
        here, steps = Turning(model, positions, _REST, ready=True), steps + 1
        g, free, unbalanced, _ = here.balanced()
        push = free.Z @ unbalanced
        largest = max(largest, float(np.max(np.abs(g) / model.inertia_scale)))
        size = float(np.linalg.norm(unbalanced))
        least, stalled = (size, 0) if size < FALLS * least else (least, stalled + 1)
        K = here.stiffness(free.P.T @ g, free)
        stiffness, directions = np.linalg.eigh(0.5 * (K + K.T))
        if np.max(np.abs(push), initial=0.0) <= BALANCED * max(largest, 1e-12):
            if stiffness.size == 0 or stiffness[0] > -NEUTRAL:
                return start._replace(positions=positions)
            step = free.Z @ directions[:, 0]
            step *= _NUDGE / float(np.max(np.abs(step) / sizes))
            positions, least, stalled = closed(model, moved(model, positions, step)), np.inf, 0
            continue
        if stiffness[0] > NEUTRAL:
            step = free.Z @ np.linalg.solve(K, unbalanced)
        else:
            along = directions.T @ unbalanced
            step = free.Z @ (directions @ (along / np.maximum(np.abs(stiffness), NEUTRAL)))
        positions = _downhill(here, g, free, limited(step, sizes))
    in_wind = "; for a rotor in the wind, use `spin=SPEED` or `start`"
    raise InputError(
        f"solver.start: no static equilibrium within {steps} steps; "
        f"{pushed(model, push, body_names)}. Expected loads that joints, springs and "
        f"elasticity can balance{in_wind if model.rotor.polar.size else ''}"
    )


def resting(model: Model, positions: Array, velocities: Array) -> Array:
    """Return the state y (n,) of positions and velocities; angles turn as at the given start.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    positions : positions (n_pos,)
    velocities : velocities (n_vel,)
    """
    return np.concatenate([positions, velocities, model.quantities.start, [0.0]])


def _at_rest(model: Model, positions: Array) -> Equations:
    still = resting(model, positions, np.zeros(model.n_vel))
    return assemble(model, 0.0, started(model, 0.0, still))


def _downhill(here: "Turning", g: Array, free: FreeMotions, step: Array) -> Array:
    """Return the position after a step, shortened until the unbalanced forces do work along it."""
    for _ in range(30):
        there = closed(here.model, moved(here.model, here.positions, step))
        if (g + here.force(there, free.P.T @ g)) @ step >= 0.0:
            break
        step = 0.5 * step
    return there


def closed(model: Model, positions: Array) -> Array:
    """Return positions with the joints closed by the least change, elastic motion included."""
    size = _size(model, positions)
    sizes, rows = sizes_of_motion(model, size), row_sizes(model, size)
    for _ in range(50):
        equations = _at_rest(model, positions)
        if np.max(np.abs(equations.Phi) / rows, initial=0.0) < BALANCE_CLOSED:
            return positions
        step = -free_motions(equations, model.inertia_scale).P @ equations.Phi
        positions = moved(model, positions, limited(step, sizes))
    raise InputError(
        "solver.start: the joints cannot be closed during the search for equilibrium "
        f"({np.max(np.abs(equations.Phi)):.2g} m or rad apart); give initial positions closer to it"
    )


def _size(model: Model, positions: Array) -> float:
    return extent(model, np.concatenate([positions[: model.n_pos], np.zeros(model.n_vel)]))


def limited(step: Array, sizes: Array) -> Array:
    """Return a step (n_vel,) that moves nothing by more than 0.3 of the size and turns 0.3 rad.

    A mode counts by its displacement: a unit of it is 2 mm in a blade of 70 t.
    """
    return step * min(1.0, _MAX_STEP / max(float(np.max(np.abs(step) / sizes)), 1e-300))


def pushed(model: Model, push: Array, body_names: list[str]) -> str:
    """Describe the largest unbalanced acceleration and its body.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    push : unbalanced accelerations (n_vel,) [m/s2, rad/s2]
    body_names : names of the bodies of the model, for messages
    """
    largest, text = -1.0, ""
    for i, name in enumerate(body_names):
        j = int(model.vel_start[i])
        parts = {
            "m/s2": np.linalg.norm(push[j : j + 3]),
            "rad/s2": np.linalg.norm(push[j + 3 : j + 6]),
            "1/s2 in a mode": np.max(
                np.abs(push[j + 6 : j + 6 + int(model.n_mode[i])]), initial=0.0
            ),
        }
        for unit, size in parts.items():
            if size > largest:
                largest, text = (
                    float(size),
                    f"body {name} still has an unbalanced acceleration of {size:.3g} {unit}",
                )
    return text


_ABOUT = "about z"  # freedom that a spin needs, in the axes of a joint
_HELD = {"x", "y", "about x", "about y"}  # freedoms that fix its axis


def given_spin(solver: "Solver") -> Spin | None:
    """Return the spin of `[solver]`, if it has one."""
    if solver.spin is None:
        return None
    return spin_about(solver.spin.axis, solver.spin.point, solver.spin.speed)


def spin_about(axis: Array | list[float], point: Array | list[float], rate: float) -> Spin:
    """Return a spin about a line; `axis` of any length.

    Parameters
    ----------
    axis : direction of the axis (3,), global
    point : a point of the axis (3,) [m]
    rate : angular velocity [rad/s]
    """
    direction = np.array(axis, dtype=float)
    return Spin(direction / np.linalg.norm(direction), np.array(point, dtype=float), float(rate))


def hub_axis(built: BuiltMechanism) -> tuple[Array, Array]:
    """Return the axis (3,) and a point of it: of the driven hinge to the ground, or the only hinge.

    Raises
    ------
    InputError
        There is none, or more than one.
    """
    driven, free = _hinges(built)
    axes = driven or free
    lines = list(axes.values())
    first = lines[0] if lines else None
    if first is not None and all(_same(first, line) for line in lines[1:]):
        return first
    if first is None:
        why = "no hinge connects a body to the ground"
    else:
        why = f"the joints {few(axes)} to the ground have different axes"
    raise InputError(
        f"the axis of the spin is missing: {why}. Expected --axis X,Y,Z, or "
        "solver.spin = { axis = [X, Y, Z] } in the case"
    )


def _hinges(built: BuiltMechanism) -> tuple[dict[str, tuple[Array, Array]], ...]:
    """Return the lines of hinges to the ground by joint: those with a drive, all."""
    model = built.model
    driven: dict[str, tuple[Array, Array]] = {}
    free: dict[str, tuple[Array, Array]] = {}
    for name, joint in built.joints.items():
        pair = [int(k) for k in model.joint_marker[joint.rows[0]]]
        ground = [k for k in pair if model.marker_body[k] == GROUND]
        removes = set(JOINTS[joint.kind].removes)
        if _ABOUT in removes or not removes >= _HELD or len(ground) != 1:
            continue
        line = model.marker_A[ground[0]][:, 2].copy(), model.marker_x[ground[0]].copy()
        free[name] = line
        drives = [DRIVES[NAMES[model.joint_kind[row]]] for row in joint.rows[1:]]
        if any(_ABOUT in drive.removes for drive in drives):
            driven[name] = line
    return driven, free


def _same(one: tuple[Array, Array], two: tuple[Array, Array]) -> bool:
    away = two[1] - one[1]
    parallel = np.linalg.norm(np.cross(one[0], two[0])) < ONE_LINE
    return bool(parallel and np.linalg.norm(np.cross(one[0], away)) < ONE_LINE)


_ROUNDING = 1e3 * float(np.finfo(float).eps)  # of positions, over the size of the mechanism
_ITERATIONS = 40
_PATIENCE = 8  # iterations in which what is unbalanced must fall by a hundredth
_TURNS = (1.0, 2.5)  # [rad] angles at which loads are compared


def relative_equilibrium(
    model: Model,
    start: Start,
    spin: Spin,
    joint_names: list[str],
    body_names: list[str],
) -> "Turning":
    """Return the relative equilibrium near the given positions; loads are those at t = 0.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    start : positions and velocities at the start, as the case gives them
    spin : rotation of the whole mechanism about a fixed axis
    joint_names : names of the joints of the model, for messages
    body_names : names of the bodies of the model, for messages

    Raises
    ------
    InputError
        Joints that do not let the mechanism turn; loads that are not constant in axes that turn
        with it; no equilibrium found.
    """
    positions = closed(model, start.positions)
    Turning(model, positions, spin).require(joint_names)
    balanced, trouble = _newton(model, positions, spin)
    if balanced is None:
        balanced, trouble = _from_rest(model, start, spin, body_names)
    if balanced is None:
        raise InputError(
            f"no relative equilibrium at a spin of {spin.rate:g} rad/s: "
            f"{pushed(model, trouble, body_names)}. Expected loads that joints, springs, "
            "elasticity and the spin can balance"
        )
    here = Turning(model, balanced, spin)
    here.require(joint_names)
    _require_constant(model, balanced, spin, body_names)
    return here


def after_turn(model: Model, y: Array, spin: Spin, t: float, angle: float) -> "Turning":
    """Return a mechanism in relative equilibrium y (n,) after it has turned by an angle [rad].

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    spin : rotation of the whole mechanism
    t : time after the turn [s]
    angle : angle of the turn [rad]
    """
    positions = turned(model, y[: model.n_pos], spin, angle)
    return Turning(model, positions, spin, t, angle)


class Turning:
    """A mechanism in given positions that turns at a spin, or is at rest.

    Attributes
    ----------
    model : its drives turn with it and its loads keep their size
    y : its state (n,)

    Parameters
    ----------
    ready : the model has the drives of the spin already
    """

    def __init__(
        self,
        model: Model,
        positions: Array,
        spin: Spin,
        t: float = 0.0,
        angle: float = 0.0,
        *,
        ready: bool = False,
    ) -> None:
        self.positions, self.spin, self.t = positions, spin, t
        self.model = model if ready else _with_spin(model, positions, spin, t, angle)
        self.v = spin_velocities(model, positions, spin)
        self.y = started(self.model, t, resting(model, positions, self.v))

    def evaluated(self) -> tuple[Equations, Array]:
        """Return the equations, and the forces (n_vel,) less those that the spin takes."""
        equations = assemble(self.model, self.t, self.y)
        if not self.spin.rate:
            return equations, equations.f
        a = spin_accelerations(self.model, self.positions, self.spin)
        return equations, equations.f - equations.M @ a

    def force(self, positions: Array, multipliers: Array) -> Array:
        """Return the forces (n_vel,), see `evaluated`, in other positions with these multipliers.

        Rates of drives are of no effect there, as multipliers are held.
        """
        near = Turning(self.model, positions, self.spin, self.t, ready=True)
        equations, g = near.evaluated()
        return np.asarray(g - equations.Phi_q.T @ multipliers)

    def stiffness(self, multipliers: Array, free: FreeMotions) -> Array:
        """Return the stiffness over inertia (n_free, n_free) [1/s2] at multipliers (n_c,)."""
        columns = [free.Z.T @ self.change(multipliers, z) for z in free.Z.T]
        return -np.array(columns).reshape((free.Z.shape[1],) * 2).T

    @cached_property
    def sizes(self) -> Array:
        """Motions (n_vel,) of the size of the mechanism."""
        return sizes_of_motion(self.model, extent(self.model, self.y))

    def change(self, multipliers: Array, step: Array) -> Array:
        """Return the first-order change of the forces (n_vel,) in a step, by central differences.

        The multipliers (n_c,) are constant.
        """
        h = _DIFFERENCE / max(float(np.max(np.abs(step) / self.sizes)), 1e-300)
        ahead, behind = (
            self.force(moved(self.model, self.positions, part * step), multipliers)
            for part in (h, -h)
        )
        return np.asarray((ahead - behind) / (2.0 * h))

    def turn(self, free: FreeMotions) -> Array | None:
        """Return the turn as a whole along the free motions (n_free,); None: a drive holds it."""
        turn = free.Z_left @ self.v
        away = np.abs(free.Z @ turn - self.v).max(initial=0.0)
        return turn if turn.any() and away <= SPIN_CONSISTENT * np.abs(self.v).max() else None

    def balanced(self, torque: float | None = None) -> tuple[Array, FreeMotions, Array, float]:
        """Return the forces (n_vel,), the free motions, and what is unbalanced along them.

        A torque about the axis, such as that which bearings take of a whirl, is the drive's that
        keeps the spin: `torque`, over that of unit motion, by default all of it; returned last.
        """
        equations, g = self.evaluated()
        free = free_motions(equations, self.model.inertia_scale)
        unbalanced, turn = free.Z.T @ g, self.turn(free)
        if turn is None:
            return g, free, unbalanced, 0.0
        share = float(turn @ unbalanced / (turn @ turn)) if torque is None else torque
        return g, free, unbalanced - share * turn, share

    def require(self, joint_names: list[str]) -> None:
        """Raise InputError if joints to the ground do not let it turn; names them."""
        equations = assemble(self.model, self.t, self.y)
        off = np.abs(equations.Phi_q @ self.v + equations.Phi_t)
        if off.size == 0 or off.max() <= SPIN_CONSISTENT * max(1.0, float(np.abs(self.v).max())):
            return
        model = self.model
        held = [
            name
            for k, name in enumerate(joint_names)
            if off[int(model.joint_row[k]) : int(model.joint_row[k + 1])].max(initial=0.0)
            > 1e-3 * off.max()
        ]
        x, y, z = self.spin.axis
        raise InputError(
            f"spin about ({x:g}, {y:g}, {z:g}): joint {few(held)} does not let the "
            "mechanism turn as a whole about this axis. Expected an axis along that of the joint "
            "to the ground"
        )


def _with_spin(model: Model, positions: Array, spin: Spin, t: float, angle: float) -> Model:
    """Return the model with drives at the rates of the spin, after a turn, and constant loads."""
    values = law_values(model, t)
    values[:, 1:] = 0.0
    laws = [int(k) for k in model.joint_law]
    if max(laws, default=-1) >= 0:
        unit = np.zeros_like(values)
        unit[[k for k in laws if k >= 0], 1] = 1.0
        y = resting(model, positions, spin_velocities(model, positions, spin))
        still = assemble(with_laws(model, t, values), t, y)
        share = assemble(with_laws(model, t, values + unit), t, y).Phi_t - still.Phi_t
        needed = -(still.Phi_q @ y[model.n_pos : model.n_pos + model.n_vel]) - still.Phi_t
        for joint, law in enumerate(laws):
            rows = slice(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))
            if law >= 0 and np.any(share[rows]):
                rate = float(needed[rows] @ share[rows] / (share[rows] @ share[rows]))
                values[law, 1] = rate
                values[law, 0] += angle * rate / spin.rate if spin.rate else 0.0
    return with_laws(model, t, values)


def _newton(
    model: Model, positions: Array, spin: Spin, *, stable: bool = False
) -> tuple[Array | None, Array]:
    """Return positions of equilibrium, or None and the unbalanced accelerations (n_vel,).

    `stable`: a minimum. Steps along motions of negative stiffness go down, by its magnitude.
    """
    patience = 2 * _PATIENCE if stable else _PATIENCE
    largest, push, last = 0.0, np.zeros(model.n_vel), [np.inf] * patience
    multipliers: Array | None = None
    for _ in range(_ITERATIONS):
        here = Turning(model, positions, spin)
        g, free, unbalanced, _ = here.balanced()
        if multipliers is None:
            multipliers = free.P.T @ g
        Phi, length = _at_rest(here.model, positions).Phi, _size(model, positions)
        push = free.Z @ unbalanced
        largest = max(largest, float(np.max(np.abs(g) / model.inertia_scale)))
        size = float(np.linalg.norm(unbalanced))
        K = here.stiffness(multipliers, free)
        stiffness, directions = np.linalg.eigh(0.5 * (K + K.T)) if stable else (np.ones(1), K)
        if np.max(np.abs(Phi) / row_sizes(model, length), initial=0.0) < BALANCE_CLOSED and (
            np.max(np.abs(push), initial=0.0) <= BALANCED * max(largest, 1e-12)
            or np.all(np.abs(push) <= round_off(model, positions, spin.rate, K, free))
        ):
            if np.all(stiffness > -NEUTRAL):
                return positions, push
            step = free.Z @ directions[:, 0]
            step *= _NUDGE / float(np.max(np.abs(step) / here.sizes))
            positions, last = moved(model, positions, step), [np.inf] * patience
            continue
        if size > FALLS * last[-patience]:
            break  # the spin is to grow in steps
        last.append(size)
        turn = here.turn(free)
        if turn is not None:  # a turn as a whole changes nothing: its stiffness is round-off
            K = K + np.abs(K).max() * np.outer(turn, turn) / float(turn @ turn)
        if stiffness.size and stiffness[0] < NEUTRAL:
            K = (directions * np.maximum(np.abs(stiffness), NEUTRAL)) @ directions.T
        step = -free.P @ Phi
        unbalanced = unbalanced + free.Z.T @ here.change(multipliers, step)
        step = limited(step + free.Z @ _solved(K, unbalanced), here.sizes)
        multipliers = free.P.T @ (g + here.change(multipliers, step))
        positions = moved(model, positions, step)
    return None, push


def round_off(model: Model, positions: Array, rate: float, K: Array, free: FreeMotions) -> Array:
    """Return the accelerations (n_vel,) that round-off of the positions makes, by K and the spin.

    A balanced rotor has no others: its loads are no measure of them.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    positions : positions (n_pos or more,)
    rate : angular velocity of the spin [rad/s]
    K : stiffness of the free motions (f, f)
    free : motions that the joints leave free
    """
    size = _size(model, positions)
    frame = np.zeros(model.n_vel)
    for j in model.vel_start:
        frame[j : j + 3], frame[j + 3 : j + 6] = size, 1.0
    by_stiffness = np.abs(free.Z) @ (np.abs(K) @ (np.abs(free.Z_left) @ frame))
    return np.asarray(_ROUNDING * (by_stiffness + rate**2 * max(1.0, size)))


def _solved(K: Array, b: Array) -> Array:
    """Return the solution of K x = b without the directions that have no stiffness."""
    U, s, Vt = np.linalg.svd(K)
    use = s > max(NEUTRAL, 1e-14 * s.max(initial=0.0))
    return np.asarray(Vt[use].T @ ((U[:, use].T @ b) / s[use]))


def _from_rest(
    model: Model, start: Start, spin: Spin, body_names: list[str]
) -> tuple[Array | None, Array]:
    """Follow the equilibrium from rest as the spin grows."""
    try:
        positions = equilibrium(model, start, body_names).positions
    except InputError:  # held up by the spin alone
        positions = closed(model, start.positions)
    share, step, push = 0.0, 0.125, np.zeros(model.n_vel)
    while share < 1.0:
        target = min(1.0, share + step)
        solution, push = _newton(model, positions, spin._replace(rate=target * spin.rate))
        if solution is None:
            step *= 0.5
            if step < LEAST_SPIN_STEP:
                return None, push
            continue
        positions, share, step = solution, target, 2.0 * step
    return positions, push


def _require_constant(model: Model, positions: Array, spin: Spin, body_names: list[str]) -> None:
    """Raise InputError if the loads change when the mechanism has turned."""
    if spin.rate == 0.0:
        return
    torque = Turning(model, positions, spin).balanced()[-1]
    for angle in _TURNS:
        there = Turning(model, turned(model, positions, spin, angle), spin, angle=angle)
        g, free, unbalanced, _ = there.balanced(torque)
        push = free.Z @ unbalanced
        loads = float(np.max(np.abs(g) / model.inertia_scale))
        if np.max(np.abs(push), initial=0.0) > CONSTANT_LOADS * max(loads, 1e-9):
            K = there.stiffness(free.P.T @ g, free)
            if np.all(np.abs(push) <= round_off(model, there.positions, spin.rate, K, free)):
                continue
            raise InputError(
                "spin: the loads are not constant in axes that turn with the mechanism: after "
                f"{np.degrees(angle):.0f} deg {pushed(model, push, body_names)}. Expected gravity "
                "and loads along the axis, or loads that follow the bodies, and springs to the "
                "ground that are the same in all directions across the axis"
            )
