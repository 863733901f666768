"""The state in which a run starts: as given, quasi-static, in equilibrium, or in steady spin."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..dynamics.model import Model
from ..dynamics.series import balance
from ..dynamics.spinning import Spin
from ..errors import InputError
from ..math.arrays import Array
from .equilibrium import equilibrium
from .inertia import require_inertia
from .initial import Start, consistent_state
from .quasi_static import quasi_static_state
from .relative_equilibrium import relative_equilibrium

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
