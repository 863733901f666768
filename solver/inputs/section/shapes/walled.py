"""Common parts of shapes of flat walls: sizes, regions, rows by plies, lines at corners."""

import math

from ....errors import InputError
from .contract import DENSITY, Parameter, Plies, Values, Wall, size
from .spacing import along, faces, rows, united

ROWS = 5  # least number of rows of a wall with corners
ROWS_WEB = 6  # the same of a web, which has corners on both faces
THINNEST = 1e-9  # wall over its length: longer lines of growing elements have no end


def wall(key: str, meaning: str) -> Parameter:
    """Return the thickness of one wall."""
    return size(f"wall_{key}", f"thickness of the {meaning}; default: wall")


WALL = size("wall", "thickness of every wall without its own thickness")
TOP = Wall("top", {"vector": [1.0, 0.0]}, "wall_top")
RIGHT = Wall("right", {"vector": [0.0, -1.0]}, "wall_right")
BOTTOM = Wall("bottom", {"vector": [-1.0, 0.0]}, "wall_bottom")
LEFT = Wall("left", {"vector": [0.0, 1.0]}, "wall_left")
WEB = Wall("web", {"vector": [0.0, -1.0]}, "wall_web")  # outermost ply on its right face

OUTER = (
    size("width", "outer width, along x2", required=True),
    size("height", "outer height, along x3", required=True),
)
SIDES = (
    wall("top", "top"),
    wall("right", "right side"),
    wall("bottom", "bottom"),
    wall("left", "left side"),
)
FLANGES = (
    size("height", "outer height, along x3", required=True),
    size("top_width", "width of the top flange, along x2", required=True),
    size("bottom_width", "width of the bottom flange; default: top_width"),
    WALL,
    wall("top", "top flange"),
    wall("web", "web"),
    wall("bottom", "bottom flange"),
    DENSITY,
)


def wall_thickness(values: Values, key: str) -> float:
    """Thickness of a wall: its own, or the common one."""
    value = values.get(key) or values.get("wall")
    if value is None:
        other = "" if key == "wall" else f" of every wall, or {key}"
        raise InputError(f"wall: missing, expected the thickness{other} [m]")
    return float(value)


def fits(thickness: dict[str, float], keys: tuple[str, ...], space: float, what: str) -> None:
    """Raise InputError if there is no space between walls."""
    if not math.fsum(thickness[key] for key in keys) < space:
        others = " and ".join(f"{key} = {thickness[key]:g}" for key in keys[1:])
        raise InputError(
            f"{keys[0]} = {thickness[keys[0]]:g}: expected, with {others}, less than {what}, "
            f"{space:g} [m]"
        )


def half_lines(
    lengths: dict[str, float], thickness: dict[str, float], density: float
) -> dict[str, float]:
    """Elements of lines between a corner and a middle: elements_*, growth_*, graded_*, even_*.

    Raises
    ------
    InputError
        A wall that is too thin for any mesh.
    """
    wall = min(thickness, key=lambda key: thickness[key])
    thinnest, longest = thickness[wall], max(lengths.values())
    if thinnest < THINNEST * longest:
        raise InputError(
            f"{wall} = {thinnest:g}: expected at least {THINNEST:g} of the length of the walls, "
            f"{longest:g} [m]"
        )
    return {
        f"{name}_{key}": value
        for key, length in lengths.items()
        for name, value in along(length, thinnest, density).items()
    }


def box_walls(values: Values) -> dict[str, float]:
    """Thickness of the four walls of a box. Raises InputError if there is no space between them."""
    keys = ("wall_top", "wall_right", "wall_bottom", "wall_left")
    thickness = {key: wall_thickness(values, key) for key in keys}
    fits(thickness, ("wall_top", "wall_bottom"), values["height"], "the height")
    fits(thickness, ("wall_left", "wall_right"), values["width"], "the width")
    return thickness


def skin_rows(plies: Plies, density: float) -> list[float]:
    """Rows of walls with mitred corners: the plies of all walls."""
    ends = united(faces(plies[region]) for region in ("top", "right", "bottom", "left"))
    return rows(ends, ROWS, "inner", density)


def flanged(values: Values) -> tuple[dict[str, float], dict[str, float]]:
    """Sizes and walls of I and channel."""
    keys = ("wall_top", "wall_web", "wall_bottom")
    thickness = {key: wall_thickness(values, key) for key in keys}
    sizes = {"height": values["height"], "top_width": values["top_width"]}
    sizes["bottom_width"] = values["bottom_width"] or values["top_width"]
    fits(thickness, ("wall_top", "wall_bottom"), sizes["height"], "the height")
    for key in ("top_width", "bottom_width"):
        if not thickness["wall_web"] < sizes[key]:
            raise InputError(
                f"wall_web = {thickness['wall_web']:g}: expected less than {key}, "
                f"{sizes[key]:g} [m]"
            )
    return sizes, thickness
