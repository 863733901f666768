"""The state in which a run starts: as given, quasi-static, in equilibrium, or in steady spin."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...dynamics.analysis.quasi_static import (
    motions_without_strain,
    quasi_static_deformations,
    quasi_static_deformations_of_loops,
)
from ...dynamics.analysis.scales import extent, shape_sizes
from ...dynamics.elements.bodies.added_inertia import undetermined_body
from ...dynamics.evaluation.dense_equations import assemble
from ...dynamics.evaluation.series import balance
from ...dynamics.evaluation.spinning import Spin
from ...dynamics.linear_algebra.dependence import is_tree
from ...dynamics.model.model import Model
from ...errors import InputError, few
from ...math.arrays import Array
from ..consistent.initial import DEFORMED, Start, consistent_state, frames_close
from .equilibrium import equilibrium
from .relative_equilibrium import relative_equilibrium


def require_inertia(
    model: Model,
    y: Array,
    body_names: list[str],
    t: float = 0.0,
    light: Callable[[], Model] | None = None,
) -> None:
    """Check that accelerations follow from the loads in state y (n,) at time t [s].

    A body without inertia in a direction must be held in it by joints. `light` gives the model with
    moderate mass points: these have inertia in the same directions, without the round-off of heavy
    ones.

    Raises
    ------
    InputError
        A body that is not; names it, the direction, and what helps.
    """
    if model.added_inertia.size == 0:
        return
    e = assemble(model, t, y)
    found = undetermined_body(e.M, e.Phi_q, model.inertia_scale, model.vel_start)
    if found is not None and light is not None:
        model = light()
        e = assemble(model, t, y)
        found = undetermined_body(e.M, e.Phi_q, model.inertia_scale, model.vel_start)
    if found is None:
        return
    body, direction = found
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


_TOLERANCE = 1e-8  # of the change of the shapes, in the norm of the strain energy
_DIVERGED = 1e8  # energy of a change, of that of the first
_NOTHING = 1e-20  # strain energy over that of the first change that is round-off
_STILL = 1e-13  # displacement over the size that is round-off
_MAX_ITERATIONS = 40


def quasi_static_state(
    model: Model, start: Start, y: Array, joint_names: list[str], body_names: list[str]
) -> Array:
    """Return the state (n,) in which the shapes of all bodies balance the loads at t = 0.

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
    first, joined, rigid, tree = 0.0, False, 0, is_tree(model)
    energies, size = np.zeros(model.n_body), extent(model, y)
    for _ in range(_MAX_ITERATIONS):
        changes = (
            quasi_static_deformations_of_loops(model, 0.0, y, rigid)
            if joined
            else quasi_static_deformations(model, 0.0, y)
        )
        energies = np.array([_energy(model, i, change) for i, change in enumerate(changes)])
        first = first or float(energies.sum())
        moves = max(
            float(np.max(shape_sizes(model, i) * np.abs(change), initial=0.0))
            for i, change in enumerate(changes)
        )
        if not np.isfinite(first) or energies.sum() <= _NOTHING * first or moves <= _STILL * size:
            break
        if not energies.sum() < _DIVERGED * first:
            raise _not_converged(body_names, energies, joined=joined)
        before, whole = y, 0.0
        y = y.copy()
        for i, change in enumerate(changes):
            a = int(model.pos_start[i]) + 7
            y[a : a + len(change)] += change
            whole += _energy(model, i, y[a : a + len(change)])
        if not (joined or tree or frames_close(model, y)):
            joined, y, rigid = True, before, motions_without_strain(model, 0.0, before)
            continue
        deformed = replace(start, positions=y[: model.n_pos])
        y = consistent_state(model, deformed, joint_names, deforming=joined)
        if energies.sum() <= _TOLERANCE**2 * whole:
            break
    else:
        raise _not_converged(body_names, energies, joined=joined)
    return y


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


def _energy(model: Model, body: int, q: Array) -> float:
    m, square = len(q), int(model.square_start[body])
    K = model.K_qq[square : square + m * m].reshape(m, m)
    return float(q @ K @ q)


_CONTRADICTION = 1e-9  # rate of a drive against the spin, relative


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

    Raises
    ------
    InputError
        As `consistent_state`, `equilibrium`, `relative_equilibrium`, `quasi_static_state` and
        `require_inertia`; a drive that does not turn with the spin.
    """
    y = consistent_state(model, start, joint_names)
    if kind == "equilibrium":
        closed = replace(start, positions=y[: model.n_pos])
        if spin is not None and spin.rate != 0.0:
            if start.velocities.any():
                raise InputError(
                    f"solver.spin.speed = {spin.rate:g}: expected no velocity, angular_velocity or "
                    "modal_rates of bodies, which turn with the spin"
                )
            y = relative_equilibrium(model, closed, spin, joint_names, body_names).y
            _require_drives(model, y, spin, joint_names)
        else:
            found = equilibrium(model, closed, body_names)
            y = consistent_state(model, found, joint_names)
    elif kind == "quasi-static":
        y = quasi_static_state(model, start, y, joint_names, body_names)
    require_inertia(model, y, body_names, light=light)
    return y


def _require_drives(model: Model, y: Array, spin: Spin, joint_names: list[str]) -> None:
    """Raise InputError if the laws of drives contradict the spin; names them."""
    off = np.abs(balance(model, np.zeros(1), y[None]).Phi_d[0])
    if off.max(initial=0.0) <= _CONTRADICTION * max(1.0, abs(spin.rate)):
        return
    joint = int(np.searchsorted(model.joint_row, int(off.argmax()), side="right")) - 1
    raise InputError(
        f"solver.spin.speed = {spin.rate:g} rad/s: {joint_names[joint]} has another rate at t = 0. "
        "Expected a drive at this speed about the axis of the spin, and none between the bodies"
    )
