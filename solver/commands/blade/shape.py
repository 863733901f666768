"""The outer shape of a blade: its airfoils, and chord, twist and thickness along the span."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...errors import nearest
from ...math.arrays import Array
from .along import STRAIGHT, Along
from .tables import Table, Tables

POINTS = 400  # of a contour
SAME = 6  # digits in which thicknesses of airfoils are equal
THICKEST = 1.05  # over the chord: a round root has 1
FARTHEST = 100.0  # [smallest chord] of the reference axis from the section
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

    Raises
    ------
    InputError : something is missing, not a number, or not possible.
    """

    def optional(parent: Table, path: str) -> Along:
        return tables.along(parent, path) if path.rpartition(".")[2] in parent else STRAIGHT

    found = Shape(
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
    size, twist = found.thickness.values, np.abs(found.twist.values)
    least = found.chord.values.min()
    for wrong, key, words in (
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
            np.abs(found.offset.values).max() > FARTHEST * abs(least),
            "outer_shape.section_offset_y",
            f"up to {np.abs(found.offset.values).max():g} m; expected metres",
        ),
        (
            np.abs(found.height.values).max() > FARTHEST * abs(least),
            "outer_shape.section_offset_x",
            f"up to {np.abs(found.height.values).max():g} m; expected metres",
        ),
        (
            (np.diff(found.length.values) <= 0.0).any() or len(found.length.values) < 2,
            "reference_axis.z",
            "expected two rising coordinates or more, from root to tip [m]",
        ),
    ):
        if wrong:
            raise tables.error(f"{key}.values", words)
    return found


def _airfoils(tables: Tables, top: Table, shape: Table) -> tuple[Airfoil, ...]:
    path = "outer_shape.airfoils"
    places: dict[str, list[float]] = {}
    for i, entry in enumerate(tables.entries(shape, path, required=True)):
        of = places.setdefault(tables.text(entry, f"{path}[{i}].name"), [])
        if entry.get("spanwise_position") is not None:
            of += tables.numbers(entry, f"{path}[{i}].spanwise_position", 1).tolist()
    if not places:
        raise tables.error(path, "expected names of airfoils")
    known = {
        tables.text(entry, f"airfoils[{i}].name"): entry
        for i, entry in enumerate(tables.entries(top, "airfoils", required=True))
    }
    found: list[Airfoil] = []
    for name in places:
        if name not in known:
            raise tables.error("airfoils", f"no airfoil {name!r}{nearest(name, known)}")
        at = f"airfoils.{name}"
        xy = tables.table(known[name], f"{at}.coordinates")
        x, y = (tables.numbers(xy, f"{at}.coordinates.{key}") for key in "xy")
        points = _ordered(tables, at, x, y)
        (size,) = tables.numbers(known[name], f"{at}.rthick", 1)
        found.append(Airfoil(name, round(float(size), SAME), points, tuple(sorted(places[name]))))
    for k, one in enumerate(found):
        for two in found[:k]:
            if one.thickness == two.thickness and not (one.places and two.places):
                words = (
                    f"{two.name} and {one.name} have the same rthick; expected spanwise_position"
                )
                raise tables.error(path, words)
    return tuple(found)


def _ordered(tables: Tables, path: str, x: Array, y: Array) -> Array:
    """Points (n, 2) from the trailing edge over the suction side, from either sense."""
    path = f"{path}.coordinates"
    if len(x) != len(y) or len(x) < 10:
        words = f"x has {len(x)} numbers and y {len(y)}; expected as many, ten or more"
        raise tables.error(path, words)
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
    upper, lower = np.trapezoid(y[nose::-1], x[nose::-1]), np.trapezoid(y[nose:], x[nose:])
    return points if upper >= lower else points[::-1]
