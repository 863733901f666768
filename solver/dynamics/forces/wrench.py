"""What a force element does to the two markers that it stands between."""

from typing import NamedTuple

from ...math.triple import Triple


class Wrench(NamedTuple):
    """Force and moment on marker two at its origin, global components, and their energy.

    Marker one gets the opposite force at the origin of marker two, unless the element is a load
    from outside.
    """

    force: Triple  # [N]
    moment: Triple  # [N m]
    potential: float  # energy stored in springs [J]
    power: float  # of dampers, actuators and loads, into the system [W]
