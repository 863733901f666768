"""The model of a mechanism whose bodies lose their second-order terms."""

import numpy as np

from .model import Model


def without_second_order(model: Model) -> Model:
    """Return a model with the same bodies without geometric stiffening, sharing all other tables.

    The same as to assemble it again, at a fraction of the time.
    """
    nothing, none = np.zeros(0), np.zeros(model.n_body + 1, dtype=np.int64)
    return model._replace(
        second_start=none,
        third_start=none,
        fourth_start=none,
        Z=nothing,
        Z_used=np.zeros_like(model.Z_used),
        G3=nothing,
        G4=nothing,
        marker_second=np.full_like(model.marker_second, -1),
        marker_H=nothing,
        marker_H_used=np.zeros_like(model.marker_H_used),
        carried_start=none,
        carried_marker=np.zeros(0, dtype=np.int64),
        carried_mass=nothing,
    )
