"""Shapes for joints: what turns is a disc about its axis, what slides a bar along it."""

import numpy as np

from ...math.arrays import Array, IntArray
from ...results import BodyGeometry
from ...results.view import BodyView, Side

WIDTH = 0.012  # of a glyph, over the size of the scene
MOST_WIDTH = 0.04  # the same, of the joint of a thick beam
OUTSIDE = 1.1  # width of a joint, over the radius of its beam
SHIFTS = ("x", "y", "z")


def glyph(free: tuple[str, ...], width: float) -> tuple[Array, IntArray]:
    """Return points (p, 3) of a joint, in its axes, and triangles (f, 3).

    free : what the joint leaves of x, y, z, about x, about y, about z (results/view.py)
    """
    shifts = [each for each in free if each in SHIFTS]
    if shifts and len(shifts) < len(SHIFTS):
        return _prism(4, 0.5 * width, 2.0 * width)
    if free == ("about z",):
        return _prism(12, 0.9 * width, 1.3 * width)
    return _ball(width)


def joint_width(body: BodyGeometry, view: BodyView, side: Side, size: float) -> float:
    """Width of a joint [m], enough to be seen outside the beam that carries it.

    size : of the scene [m]
    """
    least = WIDTH * size
    if not len(view.shapes_B):
        return least
    node = int(np.argmin(np.linalg.norm(body.nodes_B - side.position_B, axis=1)))
    around = np.linalg.norm(view.surface.offset_B[view.surface.node == node], axis=1)
    return min(max(least, OUTSIDE * float(around.max(initial=0.0))), MOST_WIDTH * size)


def foot(width: float) -> tuple[Array, IntArray]:
    """Return points and triangles of a place on the ground, as above."""
    return _prism(4, 0.8 * width, 0.8 * width)


def _prism(sides: int, radius: float, half: float) -> tuple[Array, IntArray]:
    angle = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * radius
    points = np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (-half, half)])
    k = np.arange(sides)
    there = (k + 1) % sides
    side = [
        np.column_stack(each) for each in ((k, there, there + sides), (k, there + sides, k + sides))
    ]
    fan = np.column_stack([np.zeros(sides - 2, dtype=int), k[1:-1], k[2:]])
    return points, np.concatenate([*side, fan[:, ::-1], fan + sides])


def _ball(radius: float) -> tuple[Array, IntArray]:
    points = radius * np.concatenate([np.eye(3), -np.eye(3)])
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    return points, np.array(faces)
