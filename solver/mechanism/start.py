"""The state in which a run starts: as given, quasi-static, in equilibrium, or in steady spin."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.analysis.quasi_static import (
    motions_without_strain,
    quasi_static_deformations,
    quasi_static_deformations_of_loops,
    quasi_static_rates,
)
from ..dynamics.analysis.recovery import extent, shape_sizes
from ..dynamics.elements.added_inertia import undetermined_body
from ..dynamics.elements.joints.contract import Displacement
from ..dynamics.elements.joints.table import DRIVES, NAMES
from ..dynamics.elements.marker import marker_motion
from ..dynamics.evaluation.accelerations import assemble
from ..dynamics.evaluation.elimination import is_tree
from ..dynamics.evaluation.laws import with_laws
from ..dynamics.evaluation.series import balance
from ..dynamics.model.coordinates import Spin, moved
from ..dynamics.model.model import Model, modal_matrix
from ..errors import InputError, few
from ..inputs.common.units import LENGTHS
from ..math.arrays import Array
from ..math.rotations import matrix_to_vector, rotation_matrix
from ..results.codes import START_MOVED, Finding
from .built_mechanism import BuiltMechanism, Start
from .consistent import DEFORMED, consistent_state, frames_close, with_closed_joints
from .equilibrium import equilibrium, relative_equilibrium
from .tolerances import (
    DRIVE_CONTRADICTS,
    NO_DISPLACEMENT,
    NO_STRAIN_ENERGY,
    RATES_LAST,
    SHAPES_DIVERGED,
    SHAPES_SETTLED,
)

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism


def require_inertia(
    model: Model,
    y: Array,
    body_names: list[str],
    light: Callable[[], Model] | None = None,
) -> None:
    """Check that accelerations follow from the loads in the starting state y (n,).

    A body without inertia in a direction must be held in it by joints. `light` gives the model with
    moderate mass points: these have inertia in the same directions, without the round-off of heavy
    ones.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    body_names : names of the bodies of the model, for messages
    light : returns the model with moderate mass points

    Raises
    ------
    InputError
        A body that is not; names it, the direction, and what helps.
    """
    if model.added_inertia.size == 0:
        return
    e = assemble(model, 0.0, y)
    undetermined = undetermined_body(e.M, e.Phi_q, model.inertia_scale, model.vel_start)
    if undetermined is not None and light is not None:
        model = light()
        e = assemble(model, 0.0, y)
        undetermined = undetermined_body(e.M, e.Phi_q, model.inertia_scale, model.vel_start)
    if undetermined is None:
        return
    body, direction = undetermined
    name = f"bodies.{body_names[body]}" if body < len(body_names) else "a virtual body"
    turns = float(abs(direction[3:]).max()) > 1e-6
    vector = direction[3:] if turns else direction[:3]
    axis = ", ".join(f"{x:.3g}" for x in vector / (vector @ vector) ** 0.5 + 0.0)
    how = f"turn about its axis ({axis})" if turns else f"move along ({axis})"
    raise InputError(
        f"{name}: it can {how} without inertia, and no joint holds it there, so that no "
        "acceleration follows from the loads; expected inertia about every axis that the joints "
        "leave free. Give it inertia, or a joint that holds it (universal in place of spherical)"
    )


_MAX_ITERATIONS = 40
_KEPT = 6  # last changes of the shapes that the next shapes follow from


def quasi_static_state(
    model: Model, start: Start, y: Array, joint_names: list[str], body_names: list[str]
) -> Array:
    """Return the state (n,) in which the shapes of all bodies balance the loads at t = 0.

    They change at the rate of the loads, if these change slowly and no rate is given: begun at
    rest, each mode vibrates by this rate over its frequency.

    Anderson's method: loads that follow the shapes, as those of the wind, need about half of the
    steps of plain substitution, and converge where it swings.

    Parameters
    ----------
    y : (n,) `consistent_state` of `start`

    Raises
    ------
    InputError
        As `consistent_state`; the shapes do not converge: the loads of a body grow with its
        deformation (buckling, a spin above its first frequency), or joints do not let the
        mechanism move while the shapes are held.
    """
    first, joined, rigid, tree, undeformed = 0.0, False, 0, is_tree(model), y
    size, roots = extent(model, y), _roots(model)
    shapes: list[Array] = []
    steps: list[Array] = []
    for _ in range(_MAX_ITERATIONS):
        changes = (
            quasi_static_deformations_of_loops(model, 0.0, y, rigid)
            if joined
            else quasi_static_deformations(model, 0.0, y)
        )
        scaled = [R @ change for R, change in zip(roots, changes, strict=True)]
        energies = np.array([float(part @ part) for part in scaled])
        first = first or float(energies.sum())
        moves = max(
            float(np.max(shape_sizes(model, i) * np.abs(change), initial=0.0))
            for i, change in enumerate(changes)
        )
        if (
            not np.isfinite(first)
            or energies.sum() <= NO_STRAIN_ENERGY * first
            or moves <= NO_DISPLACEMENT * size
        ):
            break
        if not energies.sum() < SHAPES_DIVERGED * first:
            raise _not_converged(body_names, energies, joined=joined)
        shapes.append(np.concatenate([R @ y[_shape(model, i)] for i, R in enumerate(roots)]))
        steps.append(np.concatenate(scaled))
        combination = _next(np.array(shapes[-_KEPT - 1 :]), np.array(steps[-_KEPT - 1 :]))
        before, y, k = y, y.copy(), 0
        for i, R in enumerate(roots):
            y[_shape(model, i)] = np.linalg.solve(R, combination[k : k + len(R)])
            k += len(R)
        if tree:
            y[: model.n_pos] = _carried(model, before, y)
        elif not (joined or frames_close(model, y)):
            joined, y, rigid = True, before, motions_without_strain(model, 0.0, before)
            shapes, steps = [], []
            continue
        velocities = _velocities_there(model, start, undeformed, y)
        deformed = start._replace(positions=y[: model.n_pos], velocities=velocities)
        y = consistent_state(model, deformed, joint_names, deforming=joined, moved=True)
        if energies.sum() <= SHAPES_SETTLED**2 * float(combination @ combination):
            break
    else:
        raise _not_converged(body_names, energies, joined=joined)
    if not joined and _gives_way(np.array(shapes), np.array(steps)):
        raise _not_converged(body_names, energies, joined=joined)
    if joined or not model.n_mode.any():
        return y
    rates, change = quasi_static_rates(model, 0.0, y)
    if not change <= RATES_LAST:  # also where the steps have overflowed
        return y
    velocities = y[model.n_pos : model.n_pos + model.n_vel].copy()
    for i, rate in enumerate(rates):
        modes = slice(int(model.vel_start[i]) + 6, int(model.vel_start[i]) + 6 + len(rate))
        still = start.given[modes] & (start.velocities[modes] == 0.0)
        velocities[modes] += np.where(still, rate, 0.0)
    moving = start._replace(positions=y[: model.n_pos], velocities=velocities)
    return consistent_state(model, moving, joint_names, moved=True)


def _velocities_there(model: Model, start: Start, before: Array, y: Array) -> Array:
    """Return the given velocities (n_vel,) for the places of y (n,), frames with the same spins.

    A frame of a bent blade tilts: with the same components in it, the blade would turn on its
    bearing, whose damper twists it.
    """
    v = start.velocities.copy()
    for i in range(model.n_body):
        a, j = int(model.pos_start[i]), int(model.vel_start[i])
        old, new = (rotation_matrix(state[a + 3 : a + 7]) for state in (before, y))
        spin = old @ v[j + 3 : j + 6]
        v[j : j + 3] += np.cross(spin, y[a : a + 3] - before[a : a + 3])
        v[j + 3 : j + 6] = new.T @ spin
    return v


def _shape(model: Model, i: int) -> slice:
    """Return the modal coordinates of body i among the positions."""
    first = int(model.pos_start[i]) + 7
    return slice(first, first + int(model.n_mode[i]))


def _roots(model: Model) -> list[Array]:
    """Return R (m, m) of each body, K = R' R: |R q|^2 is twice the strain energy."""
    stiffness = [modal_matrix(model, model.K_qq, i) for i in range(model.n_body)]
    return [np.asarray(np.linalg.cholesky(K).T) if K.size else K for K in stiffness]


def _next(shapes: Array, steps: Array) -> Array:
    """Return the next shapes (n,) from the last ones and their changes, (k, n) each."""
    one = shapes[-1] + steps[-1]
    if len(steps) == 1:
        return np.asarray(one)
    change = np.diff(steps, axis=0)
    size = np.linalg.norm(change, axis=1, keepdims=True)
    change, moved = change / size, np.diff(shapes, axis=0) / size
    share = np.linalg.lstsq(change.T, steps[-1], rcond=1e-10)[0]
    return np.asarray(one - share @ (change + moved))


def _gives_way(shapes: Array, steps: Array) -> bool:
    """Return whether loads grow faster with the shapes (k, n) than the elastic forces do.

    With the changes as steps = (J - 1) shapes + constant, J that of the loads over the stiffness:
    an eigenvalue of J above one.
    """
    if len(steps) < 2:
        return False
    U, s, Vt = np.linalg.svd(np.diff(shapes, axis=0).T, full_matrices=False)
    kept = s > 1e-6 * s[0]
    J = U[:, kept].T @ np.diff(steps, axis=0).T @ Vt[kept].T / s[kept]
    return bool(np.linalg.eigvals(J).real.max() >= 0.0)


def _carried(model: Model, before: Array, y: Array) -> Array:
    """Return positions (n_pos,) of y (n,) with both places of each joint as they were before.

    A tree: bodies follow from the ground outwards, or from a body. The joints keep their
    coordinates, so that a stiff spring of one does not push.
    """
    joined: dict[int, list[tuple[int, int, int]]] = {i: [] for i in range(-1, model.n_body)}
    for ends in model.joint_marker.tolist():
        for k, m in (ends, ends[::-1]):
            joined[int(model.marker_body[k])].append((int(model.marker_body[m]), k, m))
    # Places x of a body of y go to c + R x.
    moves: dict[int, tuple[Array, Array]] = {}
    for root in joined:
        if root in moves:
            continue
        moves[root], reached = (np.eye(3), np.zeros(3)), [root]
        while reached:
            body = reached.pop()
            R, c = moves[body]
            for other, k, m in joined[body]:
                if other in moves:
                    continue
                old_k, old_m, new_k, new_m = (
                    marker_motion(model, *pair)
                    for pair in ((k, before), (m, before), (k, y), (m, y))
                )
                turn = R @ new_k.A @ old_k.A.T
                R_m = turn @ old_m.A @ new_m.A.T
                moves[other] = R_m, c + R @ new_k.x + turn @ (old_m.x - old_k.x) - R_m @ new_m.x
                reached.append(other)
    step = np.zeros(model.n_vel)
    for i in range(model.n_body):
        (R, c), a, j = moves[i], int(model.pos_start[i]), int(model.vel_start[i])
        step[j : j + 3] = c + R @ y[a : a + 3] - y[a : a + 3]
        step[j + 3 : j + 6] = rotation_matrix(y[a + 3 : a + 7]).T @ matrix_to_vector(R)
    return moved(model, y[: model.n_pos], step)


def _not_converged(body_names: list[str], energies: Array, *, joined: bool) -> InputError:
    why = (
        "its loads at t = 0 grow with its deformation, or the mechanism cannot move with rigid "
        "bodies"
    )
    if joined:
        why = f"the joints of a loop hold it. {DEFORMED}"
    worst = [name for name, e in zip(body_names, energies, strict=False) if e == energies.max()]
    return InputError(
        f'solver.start = "quasi-static": the shape of {few(worst)} does not converge: {why}. '
        'Expected start = "positions" or "equilibrium" here'
    )


def starting_state(
    model: Model,
    start: Start,
    kind: str,
    joint_names: list[str],
    body_names: list[str],
    spin: Spin | None = None,
    light: Callable[[], Model] | None = None,
) -> Array:
    """Return the initial state y (n,) of a run; `kind` is solver.start of a case.

    With a spin, equilibrium is that of the mechanism turning at it. `light` is as in
    `require_inertia`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    start : positions and velocities at the start, as the case gives them
    kind : `solver.start` of the case
    joint_names : names of the joints of the model, for messages
    body_names : names of the bodies of the model, for messages
    spin : rotation of the mechanism in equilibrium
    light : as of `require_inertia`

    Raises
    ------
    InputError
        As `consistent_state`, `equilibrium`, `relative_equilibrium`, `quasi_static_state` and
        `require_inertia`; a drive that does not turn with the spin.
    """
    y = consistent_state(model, start, joint_names)
    if kind == "equilibrium":
        closed = start._replace(positions=y[: model.n_pos])
        if spin is not None and spin.rate != 0.0:
            if start.velocities.any():
                raise InputError(
                    f"solver.spin.speed = {spin.rate:g}: expected no velocity, angular_velocity or "
                    "modal_rates of bodies, which turn with the spin"
                )
            y = relative_equilibrium(model, closed, spin, joint_names, body_names).y
            _require_drives(model, y, spin, joint_names)
        else:
            state = equilibrium(model, closed, body_names)
            y = consistent_state(model, state, joint_names)
    elif kind == "quasi-static":
        y = quasi_static_state(model, start, y, joint_names, body_names)
    require_inertia(model, y, body_names, light=light)
    return y


def _require_drives(model: Model, y: Array, spin: Spin, joint_names: list[str]) -> None:
    """Raise InputError if the laws of drives contradict the spin; names them."""
    off = np.abs(balance(model, np.zeros(1), y[None]).Phi_d[0])
    if off.max(initial=0.0) <= DRIVE_CONTRADICTS * max(1.0, abs(spin.rate)):
        return
    joint = int(np.searchsorted(model.joint_row, int(off.argmax()), side="right")) - 1
    raise InputError(
        f"solver.spin.speed = {spin.rate:g} rad/s: {joint_names[joint]} has another rate at t = 0. "
        "Expected a drive at this speed about the axis of the spin, and none between the bodies"
    )


def _at_given_coordinates(built: BuiltMechanism) -> Model:
    """Return the model with drives that hold the coordinates of the given positions."""
    model, values = built.model, np.zeros((len(built.model.law_start) - 1, 3))
    for joint in built.joints.values():
        for drive in joint.rows[1:]:
            of = DRIVES[NAMES[model.joint_kind[drive]]].coordinate
            if isinstance(of, Displacement):
                values[model.joint_law[drive], 0] = joint.shift[of.axis]
    return with_laws(model, 0.0, values)


def moved_findings(
    mechanism: "Mechanism", built: BuiltMechanism, y0: Array, units: str = "m"
) -> list[Finding]:
    """Return one finding of all bodies that do not start, in y0 (n,), where the case says.

    Left out is what is asked for: what drives prescribe at t = 0, where a search for equilibrium
    ends, the place of a body that is given none, and that beside given deformations.

    Parameters
    ----------
    mechanism : tables of the case, checked
    built : the built mechanism
    y0 : state at the start (n,)
    units : of lengths in the text
    """
    bodies, model, start, body_names = mechanism.bodies, built.model, built.start, built.body_names
    deformed = any(getattr(body, "modal_coordinates", None) for body in bodies.values())
    if mechanism.solver.start == "equilibrium" or deformed or not model.n_constraint:
        return []
    if not _moved(model, start.positions, y0, body_names):
        return []
    still = _at_given_coordinates(built)
    given = np.concatenate([start.positions, np.zeros(model.n_vel), model.quantities.start, [0.0]])
    y = with_closed_joints(still, given)
    closes, moved, per_metre = frames_close(still, y), [], 1.0 / LENGTHS[units]
    for share, i, distance, angle in _moved(model, given, y, body_names):
        name, place = body_names[i], y[int(model.pos_start[i]) :][:7]
        own = closes and not getattr(bodies.get(name), "part_of", None)
        keys = _keys(per_metre * place[:3], place[3:]) if own else ""
        by = f"{round(distance, 12) * per_metre:.3g} {units}"
        turn = f"{round(np.degrees(angle), 9):.3g} deg"
        moved.append((share, f"{name} by {by} and {turn}{keys}"))
    if not moved:
        return []
    places = few((place_text for _, place_text in sorted(moved, reverse=True)), "; ")
    text = (
        f"to close the joints at the start, bodies were moved from their given places: {places}. "
        f"If this is the start that is meant, give these values [{units}, deg]; if not, check "
        "lengths, ground points, axes and positions"
    )
    return [START_MOVED.finding(text, t=0.0, value=max(moved)[0])]


def _moved(
    model: Model, given: Array, y: Array, body_names: list[str]
) -> list[tuple[float, int, float, float]]:
    """Return share, index, distance [m] and angle [rad] of bodies beyond the limit in y."""
    size, moved = extent(model, y), []
    for i in range(len(body_names)):
        a = int(model.pos_start[i])
        turn = rotation_matrix(given[a + 3 : a + 7]).T @ rotation_matrix(y[a + 3 : a + 7])
        angle = float(np.linalg.norm(matrix_to_vector(turn)))
        distance = float(np.linalg.norm(y[a : a + 3] - given[a : a + 3]))
        share = max(angle, distance / size if given[a : a + 3].any() else 0.0)
        if share > START_MOVED.limit:
            moved.append((share, i, distance, angle))
    return moved


def _keys(position: Array, quaternion: Array) -> str:
    """Return the keys that give a body this place, in brackets."""
    turn = np.degrees(matrix_to_vector(rotation_matrix(quaternion)))
    place, rotation = (
        ", ".join(f"{x:.9g}" for x in np.round(part, 9) + 0.0) for part in (position, turn)
    )
    return f" (position = [{place}], rotation_deg = [{rotation}])"
