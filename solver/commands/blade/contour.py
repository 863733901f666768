"""The outer contour of a blade at a station."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...math.arrays import Array
from .windio import Blade

POINTS = 400  # of a contour


def contour(blade: Blade, r: float) -> Array:
    """Points (n, 2) from the trailing edge over suction side and leading edge back [m].

    In the axes of the section: x2 from the reference axis to the leading edge, x3 to the suction
    side. Airfoils are blended by their relative thickness.
    """
    chord, offset = blade.chord.at(r), blade.offset.at(r)
    points = _blended(blade, blade.thickness.at(r))
    height = blade.height.at(r)
    return np.column_stack([offset - chord * points[:, 0], height + chord * points[:, 1]])


def _blended(blade: Blade, thickness: float) -> Array:
    ranked = sorted(blade.airfoils, key=lambda airfoil: airfoil.thickness)
    sizes = np.array([airfoil.thickness for airfoil in ranked])
    shapes = np.array([_sampled(airfoil.points) for airfoil in ranked])
    if len(ranked) == 1:
        return np.asarray(shapes[0])
    found = PchipInterpolator(sizes, shapes)(np.clip(thickness, sizes[0], sizes[-1]))
    return np.asarray(found)


def _sampled(points: Array) -> Array:
    """Both sides at the same fractions of the chord, closer together at the edges."""
    nose = int(points[:, 0].argmin())
    x = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, POINTS // 2 + 1)))
    sides = []
    for side in (points[nose::-1], points[nose:]):
        s = np.sqrt(np.clip(side[:, 0] - side[0, 0], 0.0, None))  # straight near the nose
        s, first = np.unique(s, return_index=True)
        curve = PchipInterpolator(s / s[-1], side[first, 1])
        sides.append(np.column_stack([x, curve(np.sqrt(x))]))
    suction, pressure = sides
    return np.concatenate([suction[::-1], pressure[1:]])


def edge_angle(points: Array) -> float:
    """Angle between both sides at the trailing edge [rad]; pi: a round section."""
    span = max(3, len(points) // 60)
    one, two = points[span] - points[0], points[-1 - span] - points[-1]
    cosine = one @ two / (np.linalg.norm(one) * np.linalg.norm(two))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))
