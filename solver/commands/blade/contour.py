"""The outer contour of a blade at a station."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...math.arrays import Array
from .shape import Airfoil, Shape


def contour(shape: Shape, r: float) -> Array:
    """Points (n, 2) from the trailing edge over suction side and leading edge back [m].

    In the axes of the section: x2 from the reference axis to the leading edge, x3 to the suction
    side. Airfoils are blended by their relative thickness.
    """
    chord, offset = shape.chord.at(r), shape.offset.at(r)
    points = _blended(shape, r)
    height = shape.height.at(r)
    return np.column_stack([offset - chord * points[:, 0], height + chord * points[:, 1]])


def _blended(shape: Shape, r: float) -> Array:
    """Blend by relative thickness; airfoils of the same thickness by their places on the span."""
    groups: dict[float, list[Airfoil]] = {}
    for airfoil in shape.airfoils:
        groups.setdefault(airfoil.thickness, []).append(airfoil)
    sizes = np.array(sorted(groups))
    shapes = np.array([_along_span(groups[size], r) for size in sizes])
    if len(sizes) == 1:
        return np.asarray(shapes[0])
    thickness = np.clip(shape.thickness.at(r), sizes[0], sizes[-1])
    return np.asarray(PchipInterpolator(sizes, shapes)(thickness))


def _along_span(airfoils: list[Airfoil], r: float) -> Array:
    """Shape at r of airfoils of one thickness: linear between their places."""
    if len(airfoils) == 1:
        return airfoils[0].sampled
    places = [(place, airfoil) for airfoil in airfoils for place in airfoil.places]
    places.sort(key=lambda one: one[0])
    after = next((k for k, (place, _) in enumerate(places) if place > r), len(places))
    (p0, one), (p1, two) = places[max(after - 1, 0)], places[min(after, len(places) - 1)]
    if p0 >= p1:
        return one.sampled
    f = min(max((r - p0) / (p1 - p0), 0.0), 1.0)
    return (1.0 - f) * one.sampled + f * two.sampled


def edge_angle(points: Array) -> float:
    """Angle between both sides at the trailing edge [rad]; pi: a round section."""
    span = max(3, len(points) // 60)
    one, two = points[span] - points[0], points[-1 - span] - points[-1]
    cosine = one @ two / (np.linalg.norm(one) * np.linalg.norm(two))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))
