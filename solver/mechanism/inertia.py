"""Refusal of mechanisms in which a body moves without inertia."""

from collections.abc import Callable

from ..dynamics.bodies.added_inertia import undetermined_body
from ..dynamics.dense_equations import assemble
from ..dynamics.model import Model
from ..errors import InputError
from ..math.arrays import Array


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
