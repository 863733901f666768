"""Rotation from one direction to another about their common normal."""

import numpy as np

from .arrays import Array
from .rotations import vectors_to_matrices


def shortest_rotations(one: Array, two: Array) -> Array:
    """Return matrices (k, 3, 3) that turn directions (k, 3) to others, of any length.

    Opposite directions have no such rotation: they are left as they are.
    """
    normal = np.cross(one, two)
    sine = np.linalg.norm(normal, axis=1)
    angle = np.arctan2(sine, np.einsum("ka,ka->k", one, two))
    factor = np.divide(angle, sine, out=np.zeros_like(sine), where=sine > 0.0)
    return vectors_to_matrices(factor[:, None] * normal)
