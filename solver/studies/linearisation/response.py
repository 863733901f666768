"""Transfer functions of linearised equations."""

import numpy as np

from ...math.arrays import Array
from .state_space import StateSpace


def frequency_response(space: StateSpace, w: Array) -> Array:
    """Return G = C (i w - A)^-1 B + D at angular frequencies w (k,), (k, n_out, n_in) complex.

    An input is the size of a load or actuator, or the acceleration of a drive.
    """
    unit = np.eye(len(space.A))
    return np.array(
        [space.C @ np.linalg.solve(1j * x * unit - space.A, space.B) + space.D for x in w]
    ).reshape(len(w), *space.D.shape)


def frequencies_between(low: float, high: float, count: int, resonances: Array) -> Array:
    """Return rising angular frequencies, evenly on a logarithmic scale and close to resonances."""
    near = np.concatenate([[-d, d] for d in (1e-2, 3e-3, 1e-3, 1e-4)]).ravel()
    beside = np.outer(resonances, 1.0 + near).ravel()
    found = np.concatenate([np.geomspace(low, high, count), beside])
    return np.unique(found[(found >= low) & (found <= high)])
