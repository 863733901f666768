"""Aerodynamic loads of a rotor in the wind: thrust, moment, power."""

from collections.abc import Callable

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..math.arrays import Array
from ..mechanism.built_mechanism import BuiltMechanism

UNITS = {"thrust": "N", "moment": "N m", "power": "W"}


def rotor_values(built: BuiltMechanism, quantity: str) -> Callable[[Recording], Array]:
    """Return what gives thrust, moment or power (k,) about the shaft, of all sections."""
    model = built.model
    elements = np.flatnonzero(model.rotor.section >= 0)
    places = [2 * (model.joint_kind.size + int(k)) + 1 for k in elements]
    hub, ends = int(model.force_marker[elements[0], 0]), model.force_marker[elements, 1]

    def values(recording: Recording) -> Array:
        n = recording.axes(hub)[:, :, 2]
        loads = recording.loads(places)
        if quantity == "thrust":
            return np.asarray(np.einsum("kia,ka->k", loads[:, :, :3], n))
        arms = np.stack([recording.position(int(k)) for k in ends], axis=1)
        arms -= recording.position(hub)[:, None]
        turns = np.cross(arms, loads[:, :, :3]) + loads[:, :, 3:]
        moment = np.asarray(np.einsum("kia,ka->k", turns, n))
        if quantity == "moment":
            return moment
        return moment * np.einsum("ka,ka->k", recording.spin(hub), n)

    return values
