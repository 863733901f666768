"""The outer shape of a blade and its contour at a station."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...errors import nearest
from ...math.arrays import Array
from .tables import STRAIGHT, Along, Table, Tables

# The outer shape of a blade: its airfoils, and chord, twist and thickness along the span.

POINTS = 400  # of a contour
SAME = 6  # digits in which thicknesses of airfoils are equal
THICKEST = 1.05  # over the chord: a round root has 1
FARTHEST = 100.0  # [smallest chord] of the reference axis from the section
# Of the chord: airfoils of 8 turbines are as thick as their rthick within 0.005.
DOUBTFUL, UNLIKE = 0.01, 0.2
BACK = 0.05  # of the chord, where an outline goes back; those of 8 turbines nowhere do
TURNED = 90.0  # [deg] twist that no section of a rotor has


@dataclass(frozen=True)
class Layer:
    """A layer on the shell, or of a web."""

    name: str
    material: str
    thickness: Along  # [m]
    angle: Along  # [deg]
    start: Along  # [-] arc
    end: Along  # [-] arc
    web: str  # of which it is a layer; "": of the shell


@dataclass(frozen=True)
class Airfoil:
    """Coordinates over the chord, from the trailing edge over the suction side."""

    name: str
    thickness: float  # largest over the chord
    points: Array  # (n, 2)
    places: tuple[float, ...] = ()  # on the span

    @cached_property
    def sampled(self) -> Array:
        """Both sides at the same fractions of the chord, closer together at the edges."""
        points = self.points
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


@dataclass(frozen=True, kw_only=True)
class Shape:
    """The outer shape of a blade."""

    length: Along  # [m] coordinate z along the reference axis
    prebend: Along  # [m] its x, to the suction side
    sweep: Along  # [m] its y, to the trailing edge
    chord: Along  # [m]
    twist: Along  # [deg]
    offset: Along  # [m] from the leading edge to the reference axis along the chord
    thickness: Along  # [-] over the chord
    airfoils: tuple[Airfoil, ...]
    height: Along = STRAIGHT  # [m] of the chord line over the reference axis, to the suction side


def read_shape(tables: Tables, top: Table, shape: Table, axis: Table) -> Shape:
    """Read outer shape and reference axis of a windIO file.

    Parameters
    ----------
    tables : reader of the file
    top : the whole file
    shape : table `outer_shape`
    axis : table with the reference axis

    Raises
    ------
    InputError : something is missing, not a number, or not possible.
    """

    def optional(parent: Table, path: str) -> Along:
        return tables.along(parent, path) if path.rpartition(".")[2] in parent else STRAIGHT

    outline = Shape(
        length=tables.along(axis, "reference_axis.z"),
        prebend=optional(axis, "reference_axis.x"),
        sweep=optional(axis, "reference_axis.y"),
        chord=tables.along(shape, "outer_shape.chord"),
        twist=tables.along(shape, "outer_shape.twist"),
        offset=tables.along(shape, "outer_shape.section_offset_y"),
        thickness=tables.along(shape, "outer_shape.rthick"),
        airfoils=_airfoils(tables, top, shape),
        height=optional(shape, "outer_shape.section_offset_x"),
    )
    size, twist = outline.thickness.values, np.abs(outline.twist.values)
    least = outline.chord.values.min()
    for wrong, key, message in (
        (least <= 0.0, "outer_shape.chord", "expected lengths above 0 [m]"),
        (
            size.min() <= 0.0 or size.max() > THICKEST,
            "outer_shape.rthick",
            f"{size.min():g} to {size.max():g}; expected thicknesses over the chord, 0 to 1",
        ),
        (
            twist.max() > TURNED,
            "outer_shape.twist",
            f"up to {twist.max():g}; expected degrees from {-TURNED:g} to {TURNED:g}",
        ),
        (
            np.abs(outline.offset.values).max() > FARTHEST * abs(least),
            "outer_shape.section_offset_y",
            f"up to {np.abs(outline.offset.values).max():g} m; expected metres",
        ),
        (
            np.abs(outline.height.values).max() > FARTHEST * abs(least),
            "outer_shape.section_offset_x",
            f"up to {np.abs(outline.height.values).max():g} m; expected metres",
        ),
        (
            (np.diff(outline.length.values) <= 0.0).any() or len(outline.length.values) < 2,
            "reference_axis.z",
            "expected two rising coordinates or more, from root to tip [m]",
        ),
    ):
        if wrong:
            raise tables.error(f"{key}.values", message)
    return outline


def _airfoils(tables: Tables, top: Table, shape: Table) -> tuple[Airfoil, ...]:
    path = "outer_shape.airfoils"
    places: dict[str, list[float]] = {}
    for i, entry in enumerate(tables.entries(shape, path, required=True)):
        of = places.setdefault(tables.text(entry, f"{path}[{i}].name"), [])
        if entry.get("spanwise_position") is not None:
            of += tables.numbers(entry, f"{path}[{i}].spanwise_position", 1).tolist()
    if not places:
        raise tables.error(path, "expected names of airfoils")
    known = tables.named(top, "airfoils", required=True)
    airfoils: list[Airfoil] = []
    for name in places:
        if name not in known:
            raise tables.error("airfoils", f"no airfoil {name!r}{nearest(name, known)}")
        at = f"airfoils.{name}"
        xy = tables.table(known[name], f"{at}.coordinates")
        x, y = (tables.numbers(xy, f"{at}.coordinates.{key}") for key in "xy")
        (size,) = tables.numbers(known[name], f"{at}.rthick", 1)
        points = _ordered(tables, at, x, y)
        if abs(np.ptp(y) - size) > UNLIKE:
            message = f"{size:g}, but its coordinates are {np.ptp(y):g} thick"
            raise tables.error(f"{at}.rthick", f"{message}; expected shares of the chord")
        airfoils.append(
            Airfoil(name, round(float(size), SAME), points, tuple(sorted(places[name])))
        )
    for k, one in enumerate(airfoils):
        for two in airfoils[:k]:
            if one.thickness == two.thickness and not (one.places and two.places):
                message = (
                    f"{two.name} and {one.name} have the same rthick; expected spanwise_position"
                )
                raise tables.error(path, message)
    return tuple(airfoils)


def _ordered(tables: Tables, path: str, x: Array, y: Array) -> Array:
    """Points (n, 2) from the trailing edge over the suction side, from either sense."""
    path = f"{path}.coordinates"
    if len(x) != len(y) or len(x) < 10:
        message = f"x has {len(x)} numbers and y {len(y)}; expected as many, ten or more"
        raise tables.error(path, message)
    if np.abs(y).max() > 1.0:
        raise tables.error(path, f"y is up to {np.abs(y).max():g}; expected shares of the chord")
    nose = int(x.argmin())
    if min(nose, len(x) - 1 - nose) < 3 or abs(np.ptp(x) - 1.0) > 0.1:
        raise tables.error(
            path,
            f"x = {x[0]:g} to {x[nose]:g} to {x[-1]:g}; expected points over the chord, from the "
            "trailing edge (x = 1) over one side to the leading edge (x = 0) and back",
        )
    points = np.column_stack([x, y])
    for side in (np.arange(nose, -1, -1), np.arange(nose, len(x))):
        back = np.maximum.accumulate(x[side]) - x[side]
        if back.max() > BACK:
            k = int(side[back.argmax()])
            message = f"the outline turns back at point {k + 1}, ({x[k]:g}, {y[k]:g})"
            raise tables.error(path, f"{message}; expected x from 1 to 0 and back to 1")
    upper, lower = np.trapezoid(y[nose::-1], x[nose::-1]), np.trapezoid(y[nose:], x[nose:])
    return points if upper >= lower else points[::-1]


# The outer contour of a blade at a station.


def contour(shape: Shape, r: float) -> Array:
    """Points (n, 2) from the trailing edge over suction side and leading edge back [m].

    In the axes of the section: x2 from the reference axis to the leading edge, x3 to the suction
    side. Airfoils are blended by their relative thickness.
    """
    chord, offset = shape.chord.at(r), shape.offset.at(r)
    points = blended(shape, r, lambda one: one.sampled)
    height = shape.height.at(r)
    return np.column_stack([offset - chord * points[:, 0], height + chord * points[:, 1]])


def blended(shape: Shape, r: float, numbers: Callable[[Airfoil], Array]) -> Array:
    """Blend numbers of airfoils at r by relative thickness, those of one thickness along the span.

    Parameters
    ----------
    shape : outer shape of the blade
    r : place on the span, 0 to 1
    numbers : of an airfoil, of one shape for all
    """
    groups: dict[float, list[Airfoil]] = {}
    for airfoil in shape.airfoils:
        groups.setdefault(airfoil.thickness, []).append(airfoil)
    sizes = np.array(sorted(groups))
    values = np.array([along_span(groups[size], r, numbers) for size in sizes])
    if len(sizes) == 1:
        return np.asarray(values[0])
    thickness = np.clip(shape.thickness.at(r), sizes[0], sizes[-1])
    return np.asarray(PchipInterpolator(sizes, values)(thickness))


def along_span(airfoils: list[Airfoil], r: float, numbers: Callable[[Airfoil], Array]) -> Array:
    """Return numbers at r of airfoils of one thickness: linear between their places.

    Parameters
    ----------
    airfoils : airfoils of one thickness
    r : place along the span, 0 to 1
    numbers : numbers of an airfoil
    """
    if len(airfoils) == 1:
        return numbers(airfoils[0])
    places = [(place, airfoil) for airfoil in airfoils for place in airfoil.places]
    places.sort(key=lambda one: one[0])
    after = next((k for k, (place, _) in enumerate(places) if place > r), len(places))
    (p0, one), (p1, two) = places[max(after - 1, 0)], places[min(after, len(places) - 1)]
    if p0 >= p1:
        return numbers(one)
    f = min(max((r - p0) / (p1 - p0), 0.0), 1.0)
    return (1.0 - f) * numbers(one) + f * numbers(two)


def edge_angle(points: Array) -> float:
    """Angle between both sides at the trailing edge [rad]; pi: a round section."""
    span = max(3, len(points) // 60)
    one, two = points[span] - points[0], points[-1 - span] - points[-1]
    cosine = one @ two / (np.linalg.norm(one) * np.linalg.norm(two))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


# Sizes and layers of a blade that cannot be, and those that are unlike any blade.

LONGEST, WIDEST = 300.0, 30.0  # [m] the longest blades are 150 m, with a chord of 8 m
SLENDER, STOUT = 0.005, 0.5  # chord over length; blades have 0.03 to 0.25
TWISTED = 45.0  # [deg] blades have up to 25
NO_ARC = 1e-9  # [-]
NOTHING = 1e-9  # [m] thickness that is round-off


def doubts(shape: Shape) -> Iterator[str]:
    """Yield sizes that are possible, but unlike blades: key and words."""
    length = float(np.ptp(shape.length.values))
    chord, twist = float(shape.chord.values.max()), float(np.abs(shape.twist.values).max())
    if length > LONGEST:
        yield f"reference_axis.z.values: a blade of {length:g} m; expected metres"
    if chord > WIDEST or not SLENDER < chord / length < STOUT:
        yield (
            f"outer_shape.chord.values: up to {chord:g} m, {chord / length:.3g} of the length of "
            f"{length:g} m; expected metres"
        )
    if twist > TWISTED:
        yield f"outer_shape.twist.values: up to {twist:g}; expected degrees"
    sizes, asked = [one.thickness for one in shape.airfoils], shape.thickness.values
    if asked.min() < min(sizes) - DOUBTFUL or asked.max() > max(sizes) + DOUBTFUL:
        yield (
            f"outer_shape.rthick.values: {asked.min():g} to {asked.max():g}, but airfoils from "
            f"{min(sizes):g} to {max(sizes):g}; the thinnest and the thickest are used beyond"
        )
    for one in shape.airfoils:
        own = float(np.ptp(one.points[:, 1]))
        if abs(own - one.thickness) > DOUBTFUL:
            yield (
                f"airfoils.{one.name}.rthick: {one.thickness:g}, but its coordinates are {own:g} "
                "thick; expected the same, by which airfoils are blended"
            )


def check_layers(tables: Tables, shape: Shape, layers: Sequence[Layer]) -> None:
    """Refuse layers that cannot be.

    Parameters
    ----------
    tables : reader of the file
    shape : outer shape of the blade
    layers : layers of the shell and of the webs

    Raises
    ------
    InputError : a negative thickness, one above that of the section, or nowhere an arc.
    """
    for i, layer in enumerate(layers):
        path, t = f"structure.layers[{i}]", layer.thickness
        if t.values.min() < -NOTHING:
            message = f"{t.values.min():g} of {layer.name}; expected 0 or more [m]"
            raise tables.error(f"{path}.thickness.values", message)
        for r, value in zip(t.grid.tolist(), t.values.tolist(), strict=True):
            room = shape.chord.at(r) * shape.thickness.at(r)
            if value > room:
                message = (
                    f"{value:g} of {layer.name} at r = {r:g}, where the section is {room:.3g} m"
                )
                raise tables.error(f"{path}.thickness.values", f"{message} thick; expected metres")
        if layer.web or not t.values.any():
            continue
        grid = np.union1d(np.union1d(layer.start.grid, layer.end.grid), t.grid)
        arcs = np.array([[one.at(r) for one in (layer.start, layer.end)] for r in grid])
        around = (arcs[:, 0] > 0.5) & (arcs[:, 1] < 0.5)
        if not (around | (arcs[:, 1] - arcs[:, 0] > NO_ARC)).any():
            (start, end) = arcs[0]
            message = (
                f"{layer.name} begins at {start:g} and ends at {end:g}; expected an end behind"
            )
            raise tables.error(f"{path}.end_nd_arc", f"{message} the start")
