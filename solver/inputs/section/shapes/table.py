"""The table of parametric sections: sizes and walls of each shape.

Axes: x = x2, y = x3, origin as each shape says. Layer direction y2 of a wall: y3 = x1 x y2 is its
outward normal, and plies are listed outermost first.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Parameter:
    """A size of a shape."""

    key: str
    unit: str  # "m", "deg" or "-"
    meaning: str
    default: Any = None  # of an optional one; None: taken from others, see the meaning
    required: bool = False
    above: float | None = None  # bounds: above, or from `least` on; up to `most`
    least: float | None = None
    most: float | None = None
    many: bool = False  # a list of numbers (one number stands for a list of one)
    text: bool = False  # no number


@dataclass(frozen=True)
class Wall:
    """A region of a shape."""

    region: str
    direction: Mapping[str, Any]  # {"vector": y2}, {"circle": centre} or {"curve": name}
    thickness: str  # key of its thickness
    stacked: bool = True  # plies lie one below the other through this thickness


@dataclass(frozen=True)
class Shape:
    """A parametric section."""

    script: str
    meaning: str
    parameters: tuple[Parameter, ...]
    walls: tuple[Wall, ...]  # of the airfoil: see `walls`


def _size(key: str, meaning: str, **more: Any) -> Parameter:
    return Parameter(key, "m", meaning, above=0.0, **more)


def _wall(key: str, meaning: str) -> Parameter:
    return _size(f"wall_{key}", f"thickness of the {meaning}; default: wall")


DENSITY = Parameter("density", "-", "elements along each line over the default", 1.0, above=0.0)
WALL = _size("wall", "thickness of every wall without one of its own")

TOP = Wall("top", {"vector": [1.0, 0.0]}, "wall_top")
RIGHT = Wall("right", {"vector": [0.0, -1.0]}, "wall_right")
BOTTOM = Wall("bottom", {"vector": [-1.0, 0.0]}, "wall_bottom")
LEFT = Wall("left", {"vector": [0.0, 1.0]}, "wall_left")
WEB = Wall("web", {"vector": [0.0, -1.0]}, "wall_web")  # outermost ply on its right face

_BOX = (
    _wall("top", "top"),
    _wall("right", "right side"),
    _wall("bottom", "bottom"),
    _wall("left", "left side"),
)
_FLANGES = (
    _size("height", "outer height, along x3", required=True),
    _size("top_width", "width of the top flange, along x2", required=True),
    _size("bottom_width", "width of the bottom flange; default: top_width"),
    WALL,
    _wall("top", "top flange"),
    _wall("web", "web"),
    _wall("bottom", "bottom flange"),
    DENSITY,
)
_RECTANGLE = (
    _size("width", "along x2", required=True),
    _size("height", "along x3", required=True),
)
_COUNTS = (
    Parameter("elements_2", "-", "elements along the width; default: by the sizes", least=1),
    Parameter("elements_3", "-", "elements along the height; default: by the sizes", least=1),
    Parameter("grading", "-", "spacing, 0: equal, 1: cosine", 0.5, least=0.0, most=1.0),
    DENSITY,
)
_STACK = {"vector": [1.0, 0.0]}  # plies parallel to x2, the outermost on top

SHAPES: dict[str, Shape] = {
    "rectangle": Shape(
        "rectangle",
        "solid rectangle about the origin; plies from top to bottom",
        (*_RECTANGLE, *_COUNTS),
        (Wall("section", _STACK, "height"),),
    ),
    "strip": Shape(
        "rectangle",
        "a rectangle by another name",
        (*_RECTANGLE, *_COUNTS),
        (Wall("section", _STACK, "height"),),
    ),
    "split-rectangle": Shape(
        "split-rectangle",
        "rectangle of two materials side by side; plies from top to bottom",
        (*_RECTANGLE, Parameter("interface", "m", "x2 where left and right meet", 0.0), *_COUNTS),
        (Wall("left", _STACK, "height"), Wall("right", _STACK, "height")),
    ),
    "ellipse": Shape(
        "ellipse",
        "solid ellipse about the origin",
        (
            _size("radius_2", "half-axis along x2", required=True),
            _size("radius_3", "half-axis along x3; default: radius_2"),
            Parameter("elements_arc", "-", "elements on a quarter of the edge", 10, least=1),
            Parameter("elements_radial", "-", "elements from core to edge", 6, least=1),
            DENSITY,
        ),
        (Wall("section", _STACK, "radius_3", stacked=False),),
    ),
    "tube": Shape(
        "tube",
        "circular tube about the origin, or part of one",
        (
            _size("outer_radius", "radius of the outer face", required=True),
            _size("wall", "thickness"),
            Parameter("start_deg", "deg", "where a part begins, from x2 towards x3", 0.0),
            Parameter("span_deg", "deg", "angle of the part", 360.0, above=0.0, most=360.0),
            DENSITY,
        ),
        (Wall("wall", {"circle": [0.0, 0.0]}, "wall"),),
    ),
    "box": Shape(
        "box",
        "rectangular box about the origin, mitred corners",
        (
            _size("width", "outer width, along x2", required=True),
            _size("height", "outer height, along x3", required=True),
            WALL,
            *_BOX,
            DENSITY,
        ),
        (TOP, RIGHT, BOTTOM, LEFT),
    ),
    "two-cell": Shape(
        "two-cell",
        "rectangular box about the origin with a web between top and bottom, mitred corners",
        (
            _size("width", "outer width, along x2", required=True),
            _size("height", "outer height, along x3", required=True),
            Parameter("web_position", "m", "x2 of the web's middle", 0.0),
            WALL,
            *_BOX,
            _wall("web", "web"),
            DENSITY,
        ),
        (TOP, RIGHT, BOTTOM, LEFT, WEB),
    ),
    "i": Shape(
        "i",
        "I section, its web on the x3 axis, origin half way up; sharp corners",
        _FLANGES,
        (TOP, WEB, BOTTOM),
    ),
    "channel": Shape(
        "channel",
        "channel, outer face of its web at x2 = 0, origin half way up; mitred corners",
        _FLANGES,
        (TOP, Wall("web", {"vector": [0.0, 1.0]}, "wall_web"), BOTTOM),
    ),
    "airfoil": Shape(
        "airfoil",
        "skin along an airfoil's contour with up to three webs; x2 from nose to tail. Behind the "
        "place where the skins would meet it ends with a wall of the rear skin",
        (
            Parameter(
                "contour",
                "-",
                "file of coordinates (Selig or Lednicer), or a name in meshes/airfoils",
                required=True,
                text=True,
            ),
            _size("chord", "length that the contour's unit stands for", required=True),
            Parameter("origin", "-", "place of the origin, fraction of the chord", 0.0),
            _size("skin", "thickness of the skin"),
            _size("cap", "thickness of the skin between first and last web; default: skin"),
            _size("skin_rear", "thickness of the skin behind the last web; default: skin"),
            Parameter(
                "webs", "-", "middles of the webs, fractions of the chord", (), above=0, most=1,
                many=True,
            ),
            _size("web", "thickness of each web; one number: of all; default: skin", many=True),
            DENSITY,
        ),
        (),
    ),
}  # fmt: skip
