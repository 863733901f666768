"""Sizes of forces along coordinates, and of what couplings of coordinates transmit."""

from collections.abc import Callable

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..dynamics.evaluation.evaluation import n_coupling
from ..dynamics.evaluation.series import force_sizes
from ..dynamics.model.model import ANGLE, SPIN
from ..math.arrays import Array
from ..mechanism import BuiltMechanism

Values = Callable[[Recording], Array]


def force_values(built: BuiltMechanism, of: str) -> tuple[str, Values]:
    """Return the unit, and what gives the size (k,) of a force or coupling, by its name.

    A force pushes its coordinate with this size, positive where the coordinate grows. A coupling
    pushes the first of its coordinates so, and the others in the ratio of its equation.
    """
    model, quantities = built.model, built.model.quantities
    if of in built.force_names:
        k = built.force_names.index(of)
        unit = _unit(int(quantities.kind[quantities.along[k]]))
        return unit, lambda recording: force_sizes(
            model, k, recording.t, recording.y, recording.multipliers
        )
    plain = model.joint_kind.size - n_coupling(model)
    c = built.joint_names[plain:].index(of)
    term, row = int(quantities.coupling_start[c]), int(model.joint_row[plain + c])
    ratio = float(quantities.coupling_ratio[term])
    unit = _unit(int(quantities.kind[quantities.coupling_coordinate[term]]))
    return unit, lambda recording: np.asarray(-ratio * recording.multipliers[:, row])


def _unit(kind: int) -> str:
    return "N m" if kind in (ANGLE, SPIN) else "N"
