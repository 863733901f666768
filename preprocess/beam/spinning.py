"""Static shapes of a spinning beam, which bending modes at rest represent poorly.

Under its centrifugal tension a beam rotates about its root like a rope. The bent zone at the
root becomes shorter with the speed, and modes at rest converge slowly to this shape. They are
replaced by the shapes of a sequence of loads. The first load, m x across the beam, increases along
it. Each next load is (N w')', the transverse load of the centrifugal tension N in the previous
shape w. This is the Krylov sequence of the bending stiffness and the tension: few shapes are
sufficient for all speeds from zero.
"""

import numpy as np

from ...solver.math.arrays import Array
from ..modes import Condition, StaticLoad
from .line import BeamLine

# Transverse displacement, and the rotation that equals its slope, with its sign.
PLANES = {"spinning-xy": (1, 5, 1.0), "spinning-xz": (2, 4, -1.0)}


def spinning_loads(
    condition: Condition, line: BeamLine, requested: tuple[tuple[str, int], ...], origin: int
) -> list[StaticLoad]:
    """Loads of the static modes "spinning-xy" and "spinning-xz".

    Parameters
    ----------
    condition : reference condition; not a mean axis, because a mean axis carries the first load
    line : the beam, straight and, for the tension, uniform
    requested : key of PLANES and number of shapes
    origin : node on the axis of rotation
    """
    x = line.nodes_B[:, 0] - line.nodes_B[origin, 0]
    tension = 0.5 * (np.where(x < 0.0, x[0], x[-1]) ** 2 - x**2)
    zero = np.zeros(6 * line.n_node)
    loads = []
    for kind, count in requested:
        across, turning, sign = PLANES[kind]
        pull = x
        for k in range(count):
            acceleration = np.zeros((line.n_node, 6))
            acceleration[:, across] = pull / np.abs(pull).max()
            load = acceleration.ravel()
            loads.append(StaticLoad(f"{kind} {k + 1}", zero, load))
            shape = condition.static(zero[:, None], load[:, None]).columns[:, 0]
            slope = sign * shape.reshape(-1, 6)[:, turning]
            pull = _derivative(tension * slope, line.nodes_B[:, 0])
    return loads


def _derivative(values: Array, x: Array) -> Array:
    """Derivative by x of nodal values (n,), of second order in the size of the elements."""
    return np.asarray(np.gradient(values, x, edge_order=2 if len(x) > 2 else 1))
