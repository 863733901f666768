"""A built mechanism: its model with names, its joints, and its start."""

from collections.abc import Callable
from dataclasses import field
from typing import NamedTuple

from ..dynamics.model.model import Model
from ..math.arrays import Array
from ..math.records import record
from ..package.body.package_schema import Interface, ModalPackage


class Start(NamedTuple):
    """Approximate positions and given velocities, in the order of the model's coordinates."""

    positions: Array  # (n_pos,)
    velocities: Array  # (n_vel,): values where given
    given: Array  # (n_vel,) bool: True for given velocities, which must be kept


class BuiltJoint(NamedTuple):
    """Position of a joint of the case in the model."""

    kind: str
    rows: tuple[int, ...]  # joint tables of the model: the joint itself, then its drives
    shift: Array  # (3,) vector from place one to two at the given start, in the joint's axes [m]


@record
class BuiltMechanism:
    """A model with the names of its bodies, joints and places."""

    model: Model
    start: Start
    body_names: list[str]  # bodies of the case, then virtual bodies
    joint_names: list[str]  # one per joint row block, drives included
    packages: dict[str, ModalPackage]  # flexible bodies only
    places: dict[str, tuple[int, Interface]]  # "BODY.INTERFACE" -> body index, interface
    joints: dict[str, BuiltJoint]  # joints of the case
    signal_marker: dict[str, int]  # signal of a place -> marker index
    state_names: list[str]  # auxiliary states, without those that count turns
    light: Callable[[], Model]  # the same with mass points of moderate mass (`heaviest` of `build`)
    force_names: list[str]  # in the order of the force elements of the model
    callers: tuple[str, ...] = ()  # forces whose values come from functions of the user
    point_masses: tuple[tuple[int, float], ...] = ()  # marker and mass [kg], not of virtual bodies
    markers: dict[str, int] = field(default_factory=dict)  # of all places, if they were asked for


def frame_marker(signal: str, number: int) -> str:
    """Return the name of a marker that carries the frame of a signal of a body in segments."""
    return f"{signal}#{number}"
