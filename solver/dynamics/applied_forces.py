"""Force elements and loads: their wrenches, added to the generalised forces of the bodies."""

from ..math.compiled import inlined, lean
from ..math.triple import Triple, cross3, minus3, sum3, times3, triple
from .bodies.motion import place
from .forces.contract import Wrench
from .forces.table import FIRST_LOAD, element_wrench
from .laws import law_at
from .measures import force_size
from .model import Model
from .workspace import Work


@lean
def force_wrench(model: Model, work: Work, k: int, t: float) -> Wrench:
    """Wrench of force element k at time t, with the quantities and markers of `work`."""
    size = 0.0
    if model.force_law[k] >= 0:
        size, _, _ = law_at(model, model.force_law[k], t)
    elif model.quantities.force[k] >= 0:
        force_size(model.quantities, k, t, work.quantity, work.size[k])
        size = work.size[k, 0]
    if model.quantities.along[k] >= 0:
        return coordinate_wrench(model, work, k, size)
    one = work.motion[model.force_marker[k, 0]]
    two = work.motion[model.force_marker[k, 1]]
    return element_wrench(model.force_kind[k], one, two, model.force_parameters[k], size)


@inlined
def coordinate_wrench(model: Model, work: Work, k: int, size: float) -> Wrench:
    """Wrench of force element k of a size along its coordinate.

    By the row of the coordinate: virtual work size g (v_1, w_1, v_2, w_2).
    """
    along = model.quantities.along[k]
    push = times3(size, triple(work.g[along, 6:9]))
    turn = times3(size, triple(work.g[along, 9:12]))
    return Wrench(push, turn, 0.0, size * work.quantity[2 * along + 1])


@inlined
def add_forces(model: Model, work: Work, t: float) -> None:
    """Add the force elements to f, their power and their stored energy."""
    for k in range(model.force_kind.shape[0]):
        add_wrench(model, work, k, force_wrench(model, work, k, t))


@inlined
def add_wrench(model: Model, work: Work, k: int, wrench: Wrench) -> None:
    """Add a wrench of force element k to f, its power and its stored energy."""
    work.power[0] += wrench.power
    work.power[1] += wrench.potential
    _push(model, work, model.force_marker[k, 1], wrench.force, wrench.moment, 1.0)
    if model.force_kind[k] < FIRST_LOAD:
        one = work.motion[model.force_marker[k, 0]]
        two = work.motion[model.force_marker[k, 1]]
        arm = cross3(minus3(place(two), place(one)), wrench.force)
        moment = sum3(wrench.moment, arm)
        _push(model, work, model.force_marker[k, 0], wrench.force, moment, -1.0)


@inlined
def _push(model: Model, work: Work, k: int, force: Triple, moment: Triple, sign: float) -> None:
    """Add force and moment, global components, times `sign` at marker k to f."""
    body = model.marker_body[k]
    if body < 0:
        return
    for j in range(model.plan.size[body]):
        for a in range(3):
            push = work.J_m[k, a, j] * force[a] + work.J_m[k, 3 + a, j] * moment[a]
            work.f[body, j] += sign * push
