"""Force elements (springs, bushings, loads) from the tables of a case."""

import numpy as np

from ..dynamics.tables import ForceTable
from ..inputs.case.forces import Bushing, Force, ForceLoad, RotarySpring, Spring, TorqueLoad
from ..inputs.case.schema import Mechanism
from .laws import law_of
from .places import Places, axes

_Z = [0.0, 0.0, 1.0]


def force_tables(mechanism: Mechanism, places: Places) -> list[ForceTable]:
    """Return the force elements in the order of the case."""
    return [_element(name, force, places) for name, force in mechanism.forces.items()]


def _element(name: str, force: Force, places: Places) -> ForceTable:
    if isinstance(force, ForceLoad | TorqueLoad):
        return _load(name, force, places)
    if isinstance(force, Spring):
        A_GM = axes(_Z)
    else:
        A_GM = axes(force.axis, force.axis_1 if isinstance(force, Bushing) else None)
    key = f"forces.{name}.between"
    one, two = (places.marker(key, place, A_GM) for place in force.between)
    if isinstance(force, Bushing):
        constants = (
            *force.stiffness,
            *force.rotary_stiffness,
            *force.damping,
            *force.rotary_damping,
        )
        return ForceTable(name, force.kind, one, two, constants)
    law = law_of(force.actuator) if force.actuator is not None else None
    rest = force.angle if isinstance(force, RotarySpring) else force.length
    if rest is None:
        rest = float(np.linalg.norm(places.shift(one, two)))
    return ForceTable(name, force.kind, one, two, (force.stiffness, force.damping, rest), law)


def _load(name: str, load: ForceLoad | TorqueLoad, places: Places) -> ForceTable:
    at = places.marker(f"forces.{name}.at", load.at, np.eye(3))
    reference = at if load.frame == "following" else places.ground_axes()
    direction = np.array(load.direction, dtype=float)
    direction /= np.linalg.norm(direction)
    return ForceTable(name, load.kind, reference, at, tuple(direction.tolist()), law_of(load.law))
