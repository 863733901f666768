"""Curved and twisted beams: places on the reference line, nodes and section axes of the elements.

Between its nodes an element is straight. Its section axes are those of the line in its middle:
x1 along the element, x2 carried along the line without rotation about it (parallel transport) and
then rotated about it by `twist_deg`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ....math.arrays import Array
from ....math.curves import lengths_along
from ....math.rotations import shortest_rotations, vector_to_matrix
from ....package.body.division import node_positions
from ....package.specification import LineTable
from ..tables.beam_schema import BeamBody
from ..tables.beam_table import Spline

ENDS = {"start": 0.0, "end": 1.0}
DIGITS = 12  # of coordinates over the length: equal segments get equal numbers


@dataclass(frozen=True)
class Line:
    """Reference line of a beam in its body frame.

    Attributes
    ----------
    length : along the line [m]
    place : fractions of the length (k,) -> positions (k, 3) [m]
    x2 : fractions (k,) -> x2 of the section (k, 3), normal to the line except for round-off
    """

    length: float
    place: Callable[[Array], Array]
    x2: Callable[[Array], Array]


def fractions(body: BeamBody) -> dict[str, float]:
    """Return the place of each interface as a fraction of the length."""
    return {n: i.at if isinstance(i.at, float) else ENDS[i.at] for n, i in body.interfaces.items()}


def is_plain(body: BeamBody) -> bool:
    """Return whether the beam is straight and without twist."""
    return body.line is None and not body.twist_deg


def division(body: BeamBody, line: Line) -> Array:
    """Return the nodes of a beam as fractions of its length, (n,)."""
    if body.line is not None and body.line.nodes is not None:
        along = lengths_along(np.array(body.line.nodes))
        return np.asarray(along / along[-1])
    stops = [*fractions(body).values(), *(s.at for s in body.stations if 0.0 < s.at < 1.0)]
    return node_positions(1.0, body.elements, stops)


def line_table(line: Line, nodes: Array) -> LineTable:
    """Return nodes and axes of the elements between fractions `nodes` (n,) of a line."""
    return {
        "nodes": rounded(line.place(nodes), line.length),
        "x2_axes": rounded(line.x2(0.5 * (nodes[:-1] + nodes[1:])), 1.0),
    }


def line_of(body: BeamBody) -> Line:
    """Return the reference line of a beam."""
    given = body.line
    if given is not None and given.nodes is not None:
        return _through_nodes(np.array(given.nodes), np.array(given.x2_axes))
    x2 = np.array(body.x2_axis)
    if given is None:
        assert body.length is not None
        length = body.length
        return _twisted(
            body,
            length,
            lambda s: np.outer(length * s, [1.0, 0.0, 0.0]),
            lambda s: np.tile(np.eye(3), (len(s), 1, 1)),
            x2,
        )
    if given.arc_deg is not None:
        assert body.length is not None
        return _arc(body, np.radians(given.arc_deg), np.array(given.axis), body.length, x2)
    return _through_points(body, np.array(given.points), x2)


def _arc(body: BeamBody, total: float, axis: Array, length: float, x2: Array) -> Line:
    """A circular arc; the tangent turns by `total` [rad]."""
    axis = axis / np.linalg.norm(axis)
    e1 = np.array([1.0, 0.0, 0.0])

    def place(s: Array) -> Array:
        a = total * s
        along = np.outer(np.sin(a), e1) + np.outer(1.0 - np.cos(a), np.cross(axis, e1))
        return np.asarray(length / total * along)

    def turns(s: Array) -> Array:
        return np.array([vector_to_matrix(angle * axis) for angle in total * s])

    return _twisted(body, length, place, turns, x2)


def _through_points(body: BeamBody, points: Array, x2: Array) -> Line:
    """A cubic spline by the lengths of the chords, measured along itself."""
    spline = Spline(points)
    u, tangents = spline.u, spline.tangents
    turn = np.zeros((len(u), 3, 3))
    turn[0] = np.eye(3)
    for k, step in enumerate(shortest_rotations(tangents[:-1], tangents[1:])):
        turn[k + 1] = step @ turn[k]

    def turns(s: Array) -> Array:
        nearest = np.clip(np.searchsorted(u, spline.parameter(s)), 0, len(u) - 1)
        return shortest_rotations(tangents[nearest], spline.tangent(s)) @ turn[nearest]

    first = x2 - (x2 @ tangents[0]) * tangents[0]
    first = first / np.linalg.norm(first)
    return _twisted(body, spline.length, spline.place, turns, first, tangents[0])


def _through_nodes(nodes: Array, axes: Array) -> Line:
    """Given nodes: places on the polygon, axes of its sides."""
    along = lengths_along(nodes)
    along = along / along[-1]

    def place(s: Array) -> Array:
        return np.array([np.interp(s, along, column) for column in nodes.T]).T

    def x2(s: Array) -> Array:
        return axes[np.clip(np.searchsorted(along, s, side="right") - 1, 0, len(axes) - 1)]

    return Line(float(lengths_along(nodes)[-1]), place, x2)


def _twisted(
    body: BeamBody,
    length: float,
    place: Callable[[Array], Array],
    turns: Callable[[Array], Array],
    x2: Array,
    tangent: Array | None = None,
) -> Line:
    first = np.array([1.0, 0.0, 0.0]) if tangent is None else tangent
    table = np.array([pair for pair in body.twist_deg] or [[0.0, 0.0]])

    def axes(s: Array) -> Array:
        angles = np.radians(np.interp(s, table[:, 0], table[:, 1]))
        own = [vector_to_matrix(angle * first) @ x2 for angle in angles]
        return np.einsum("kab,kb->ka", turns(s), own)

    return Line(length, place, axes)


def rounded(values: Array, size: float) -> list[list[float]]:
    """Plain numbers without the last digits, so that equal lines have equal ones."""
    plain: list[list[float]] = (np.round(values / size, DIGITS) * size + 0.0).tolist()
    return plain
