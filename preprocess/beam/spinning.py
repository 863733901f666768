"""Static shapes of a beam that spins: what bending modes at rest miss of a beam under tension.

Spinning holds a beam by its tension: it turns about its root like a rope, with a bent layer at the
root that narrows with the speed. Vibrations at rest follow that slowly. Their place is taken by a
chain of loads: the first, m x across the beam, rises along it; the next is the pull across the
beam of the centrifugal tension N in the shape w of the load before, (N w')'. That is the sequence
of Krylov of the bending stiffness and the tension: few shapes serve all speeds from rest on.
"""

import numpy as np

from ...solver.math.arrays import Array
from ..modes import Condition, StaticLoad
from .line import BeamLine

# Displacement across the beam and the rotation that is its slope, with its sign.
PLANES = {"spinning-xy": (1, 5, 1.0), "spinning-xz": (2, 4, -1.0)}


def spinning_loads(
    condition: Condition, line: BeamLine, asked: tuple[tuple[str, int], ...], origin: int
) -> list[StaticLoad]:
    """Loads of the static modes "spinning-xy" and "spinning-xz".

    Parameters
    ----------
    condition : what ties the frame to the beam; no mean axis, which carries the first load
    line : the beam, of one section
    asked : key of PLANES and number of shapes
    origin : the node that the axis of rotation goes through
    """
    x = line.x_B - line.x_B[origin]
    tension = 0.5 * (np.where(x < 0.0, x[0], x[-1]) ** 2 - x**2)
    zero = np.zeros(6 * line.n_node)
    loads = []
    for kind, count in asked:
        across, turning, sign = PLANES[kind]
        pull = x
        for k in range(count):
            acceleration = np.zeros((line.n_node, 6))
            acceleration[:, across] = pull / np.abs(pull).max()
            load = acceleration.ravel()
            loads.append(StaticLoad(f"{kind} {k + 1}", zero, load))
            shape = condition.static(zero[:, None], load[:, None]).columns[:, 0]
            slope = sign * shape.reshape(-1, 6)[:, turning]
            pull = _derivative(tension * slope, line.x_B)
    return loads


def _derivative(values: Array, x: Array) -> Array:
    """Derivative by x of nodal values (n,), of second order in the size of the elements."""
    return np.asarray(np.gradient(values, x, edge_order=2 if len(x) > 2 else 1))
