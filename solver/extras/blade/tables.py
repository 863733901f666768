"""Tables of a windIO file: keys, quantities along the span, places on the contour."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...errors import InputError, nearest
from ...math.arrays import Array
from ...math.laws import lengths_along

# Quantities along the span of a blade.

NEAR = 1e-9  # of the span: distance that is round-off


@dataclass(frozen=True)
class Along:
    """A quantity over the span, linear between its points."""

    grid: Array  # (n,) rising, of 0 to 1
    values: Array  # (n,)

    def at(self, r: float) -> float:
        """Value at r of 0 to 1; outside of the grid that of its end."""
        return float(np.interp(r, self.grid, self.values))

    def covers(self, r: float) -> bool:
        """True if r is within the grid: what a file gives on a part of the span is only there."""
        return bool(self.grid[0] - NEAR <= r <= self.grid[-1] + NEAR)

    def smooth(self, r: Array) -> Array:
        """Values at r (n,) of a monotone cubic curve through its points."""
        grid, first = np.unique(self.grid, return_index=True)
        if len(grid) < 2:
            return np.full(len(r), self.values[0])
        inside = np.clip(r, grid[0], grid[-1])
        return np.asarray(PchipInterpolator(grid, self.values[first])(inside))


STRAIGHT = Along(np.zeros(1), np.zeros(1))
WHOLE = STRAIGHT, Along(np.zeros(1), np.ones(1))  # start and end of all of a web

# Tables of a windIO file: entries by key, with messages that name file and key.

LARGEST = 1e30  # squares and products of larger numbers overflow
Table = Mapping[str, Any]


class Tables:
    """Reads entries of a file; every method raises InputError if an entry is not as expected."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def error(self, key: str, message: str) -> InputError:
        """Return an error that names the file and the key."""
        return InputError(f"{self.file}: {key}: {message}")

    def table(self, parent: Table, path: str) -> Table:
        """Return the table of the last part of `path`."""
        key = path.rpartition(".")[2]
        value = parent.get(key)
        if not isinstance(value, dict):
            known = [str(name) for name in parent if name != key]
            hint = nearest(key, known) if value is None else ""
            raise self.error(path, f"{_found(value)}; expected a table of windIO 2{hint}")
        return value

    def entries(self, parent: Table, path: str, *, required: bool = False) -> list[Table]:
        """Return the list of tables of the last part of `path`; without it, none.

        Parameters
        ----------
        parent : table that has the key
        path : keys from the top of the file, with dots
        required : a missing key is an error
        """
        value = parent.get(path.rpartition(".")[2])
        if value is None and not required:
            return []
        if not isinstance(value, list):
            raise self.error(path, f"{_found(value)}; expected a list of tables")
        for i, entry in enumerate(value):
            if not isinstance(entry, dict):
                raise self.error(f"{path}[{i}]", f"has {_kind(entry)}; expected a table")
        return value

    def named(self, parent: Table, path: str, *, required: bool = False) -> dict[str, Table]:
        """Return the tables of a list by their `name`; the same table may be there twice.

        Parameters
        ----------
        parent : table that has the key
        path : keys from the top of the file, with dots
        required : a missing key is an error
        """
        found: dict[str, Table] = {}
        for i, entry in enumerate(self.entries(parent, path, required=required)):
            name = self.text(entry, f"{path}[{i}].name")
            if found.setdefault(name, entry) != entry:
                message = f"{name!r} is the name of another one; expected different names"
                raise self.error(f"{path}[{i}].name", message)
        return found

    def text(self, parent: Table, path: str) -> str:
        """Return the name of the last part of `path`."""
        value = parent.get(path.rpartition(".")[2])
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise self.error(path, f"{_found(value)}; expected a name")
        return str(value)

    def numbers(self, parent: Table, path: str, count: int | None = None) -> Array:
        """Return numbers (count,) of the last part of `path`; without count, one or more.

        Parameters
        ----------
        parent : table that has the key
        path : keys from the top of the file, with dots
        count : how many numbers; None: one or more
        """
        value = parent.get(path.rpartition(".")[2])
        if value is None:
            raise self.error(path, "missing; expected numbers")
        wanted = "numbers" if count is None else f"{count} numbers" if count > 1 else "a number"
        try:
            if any(isinstance(v, bool) for v in (value if isinstance(value, list) else [value])):
                raise TypeError
            values = np.array(value if count != 1 else [value], dtype=float)
        except (TypeError, ValueError, OverflowError):
            values = np.array(np.nan)
        if values.ndim != 1 or len(values) != (count or max(len(values), 1)):
            raise self.error(path, f"has {_kind(value)}; expected {wanted}")
        if not (np.abs(values) <= LARGEST).all():
            raise self.error(path, f"expected {wanted}, finite ones, up to {LARGEST:g}")
        return values

    def along(self, parent: Table, path: str) -> Along:
        """Return the quantity along the span of the last part of `path`."""
        value = parent.get(path.rpartition(".")[2])
        if not isinstance(value, dict) or not {"grid", "values"} <= value.keys():
            message = "lacks grid or values" if isinstance(value, dict) else _found(value)
            raise self.error(path, f"{message}; expected a table with grid and values")
        grid, values = (self.numbers(value, f"{path}.{key}") for key in ("grid", "values"))
        if len(grid) != len(values):
            raise self.error(path, f"grid has {len(grid)} numbers and values {len(values)}")
        if (np.diff(grid) < 0).any():
            raise self.error(path, "expected a grid that rises")
        if grid[0] < -NEAR or grid[-1] > 1.0 + NEAR:
            message = f"{grid[0]:g} to {grid[-1]:g}; expected 0 at the root to 1 at the tip"
            raise self.error(f"{path}.grid", message)
        return Along(grid, values)


def _found(value: Any) -> str:
    """What is in the place of an expected entry."""
    return "missing" if value is None else f"has {_kind(value)}"


def _kind(value: Any) -> str:
    """What an entry is, in words for a message."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return repr(value)


# Places of layers and webs on the contour: numbers, other anchors, and rules.
#
# An anchor of windIO has numbers for each of its handles (`start_nd_arc`, `end_nd_arc`,
# `midpoint_nd_arc`), and may have rules that say which of them they define: `width`, `offset_arc`,
# `offset_nd_arc` and `plane_intersection`. The numbers are meant to be the result of the rules, but
# files also have placeholders there. So a rule holds where the numbers are not its result; what
# numbers other than placeholders are off by is reported as a difference.

START, END, MIDDLE = HANDLES = ("start_nd_arc", "end_nd_arc", "midpoint_nd_arc")
OTHER = {START: END, END: START}
RULES = ("width", "offset_arc", "offset_nd_arc", "plane_intersection")
# Numbers nearer to the rule are its result on a contour of other points: those of the reference
# turbines are within 0.005 (docs/blade.md).
AGREE = 0.01
STEPS = 100  # of the span, at which rules are evaluated, besides those of their grids
# What windIO's converter writes for an end that a rule of the anchor of this name defines.
UNDEFINED = {"name": "not_defined", "handle": "not_defined"}
DEEPEST = 20  # anchors that refer to each other


class Anchors:
    """Evaluates the anchors of a blade.

    Parameters
    ----------
    contour : contour (n, 2) without twist at r [m], from the trailing edge over the suction side
    twist : of the blade [deg]
    sweep : y of the reference axis [m], to the trailing edge
    """

    def __init__(
        self,
        tables: Tables,
        structure: Table,
        contour: Callable[[float], Array],
        twist: Along,
        sweep: Along,
    ) -> None:
        self.tables, self.contour, self.twist, self.sweep = tables, contour, twist, sweep
        self.entries: dict[str, tuple[str, Table]] = {}
        self.differences: list[str] = []
        self.found: dict[tuple[str, str], Along] = {}
        self.contours: dict[float, tuple[Array, Array]] = {}
        places = [(structure, "structure.anchors")]
        for i, web in enumerate(tables.entries(structure, "structure.webs")):
            places.append((web, f"structure.webs[{i}].anchors"))
        for parent, path in places:
            for i, entry in enumerate(tables.entries(parent, path)):
                name = tables.text(entry, f"{path}[{i}].name")
                if self.entries.get(name, ("", entry))[1] != entry:
                    message = f"{name!r} is the name of another anchor; expected different names"
                    raise tables.error(f"{path}[{i}].name", message)
                self.entries[name] = f"structure.anchors.{name}", entry

    def arc(self, entry: Table, path: str) -> Along:
        """Return the place that an entry of a layer or web has: numbers, or those of an anchor."""
        key = path.rpartition(".")[2]
        value = entry.get(key)
        if isinstance(value, dict) and "anchor" in value:
            if value["anchor"] == UNDEFINED and entry.get("name") in self.entries:
                return self._of(str(entry["name"]), key)
            return self._of(*self._reference(value, path))
        return self._numbers(entry, path)

    def _reference(self, parent: Table, path: str) -> tuple[str, str]:
        """Name and handle of an anchor that an entry refers to."""
        anchor = self.tables.table(parent, f"{path}.anchor")
        name = self.tables.text(anchor, f"{path}.anchor.name")
        handle = self.tables.text(anchor, f"{path}.anchor.handle")
        if name not in self.entries:
            raise self.tables.error(path, f"no anchor {name!r}{nearest(name, self.entries)}")
        if handle not in HANDLES:
            message = f"no handle {handle!r}; expected {', '.join(HANDLES)}"
            raise self.tables.error(f"{path}.anchor", message)
        return name, handle

    def _numbers(self, entry: Table, path: str) -> Along:
        value = entry.get(path.rpartition(".")[2])
        if not isinstance(value, dict) or "grid" not in value:
            raise self.tables.error(path, "expected numbers in grid and values, or a rule")
        arcs = self.tables.along(entry, path)
        if arcs.values.min() < -AGREE or arcs.values.max() > 1.0 + AGREE:
            raise self.tables.error(f"{path}.values", "expected arcs from 0 to 1")
        return arcs

    def _of(self, name: str, handle: str, depth: int = 0) -> Along:
        """The place of an anchor along the span."""
        if (name, handle) not in self.found:
            self.found[name, handle] = self._evaluated(name, handle, depth)
        return self.found[name, handle]

    def _evaluated(self, name: str, handle: str, depth: int) -> Along:
        path, entry = self.entries[name]
        if depth > DEEPEST:
            raise self.tables.error(path, "its place is defined by its own place")
        rule = next((key for key in RULES if handle in self._defined(entry, path, key)), None)
        given = entry.get(handle)
        numbers: Along | None = None
        if isinstance(given, dict) and "anchor" in given:
            numbers = self._of(*self._reference(given, f"{path}.{handle}"), depth + 1)
        elif given is not None or rule is None:
            numbers = self._numbers(entry, f"{path}.{handle}")
        if rule is None:
            assert numbers is not None
            return numbers
        ruled = getattr(self, f"_{rule}")(entry, f"{path}.{rule}", handle, depth + 1)
        return self._both(f"{path}.{handle}", rule, ruled, numbers)

    def _both(self, path: str, rule: str, ruled: Along, numbers: Along | None) -> Along:
        """The numbers if they are the result of the rule; if not, the rule where it is given."""
        if numbers is None or set(numbers.values.tolist()) in ({0.0}, {1.0}):  # placeholders
            return ruled
        grid = numbers.grid[[ruled.covers(r) for r in numbers.grid]]
        off = np.array([abs(ruled.at(r) - numbers.at(r)) for r in grid])
        if off.max(initial=0.0) <= AGREE:
            return numbers
        r = float(grid[off.argmax()])
        self.differences.append(
            f"{path}: {rule} gives {ruled.at(r):.4f} at r = {r:g}, values {numbers.at(r):.4f}; "
            "the rule is used"
        )
        beyond = np.array([not ruled.covers(r) for r in numbers.grid])
        grid = np.concatenate([ruled.grid, numbers.grid[beyond]])
        values = np.concatenate([ruled.values, numbers.values[beyond]])
        order = np.argsort(grid, kind="stable")
        return Along(grid[order], values[order])

    def _defined(self, entry: Table, path: str, rule: str) -> tuple[str, ...]:
        """The handles that a rule of an anchor defines."""
        if entry.get(rule) is None:
            return ()
        defines = self.tables.table(entry, f"{path}.{rule}").get("defines")
        names = tuple(defines) if isinstance(defines, list) else (defines,)
        if not names or not all(one in HANDLES for one in names):
            raise self.tables.error(f"{path}.{rule}.defines", f"expected {', '.join(HANDLES)}")
        return names

    def _width(self, entry: Table, path: str, handle: str, depth: int) -> Along:
        """Half the width to either side of the midpoint, or all of it from the other end."""
        name = self.tables.text(entry, "name")
        width = self.tables.along(entry, path)
        if width.values.min() < 0.0:
            raise self.tables.error(f"{path}.values", "expected widths of 0 or more [m]")
        parent = path.rpartition(".")[0]
        middle = OTHER[handle] in self._defined(entry, parent, "width")
        if (
            middle
            and MIDDLE not in entry
            and MIDDLE not in self._defined(entry, parent, "plane_intersection")
        ):
            message = "defines both ends; expected midpoint_nd_arc, or a plane that defines it"
            raise self.tables.error(path, message)
        start = self._of(name, MIDDLE if middle else OTHER[handle], depth)
        share = (0.5 if middle else 1.0) * (-1.0 if handle == START else 1.0)

        def at(r: float) -> float:
            s, size = self._contour(r)[1], width.at(r)
            trailing = min(start.at(r), 1.0 - start.at(r)) < 1e-6
            if trailing and not middle:  # beyond the face of a flatback, which it covers
                size += float(s[1])
            arc = start.at(r) + share * size / s[-1]
            if trailing and middle and size > 0.0:  # around the trailing edge
                return float(arc % 1.0)
            return float(min(max(arc, 0.0), 1.0))

        return self._sampled(path, at, width, start)

    def _offset_arc(self, entry: Table, path: str, handle: str, depth: int) -> Along:
        """A length from another anchor [m]."""
        return self._offset(entry, path, depth, lambda r: float(self._contour(r)[1][-1]))

    def _offset_nd_arc(self, entry: Table, path: str, handle: str, depth: int) -> Along:
        """An arc from another anchor [-]."""
        return self._offset(entry, path, depth, lambda r: 1.0)

    def _offset(self, entry: Table, path: str, depth: int, unit: Callable[[float], float]) -> Along:
        rule = self.tables.table(entry, path)
        offset = self.tables.along(entry, path)
        start = self._of(*self._reference(rule, path), depth)
        return self._sampled(
            path, lambda r: min(max(start.at(r) + offset.at(r) / unit(r), 0.0), 1.0), offset, start
        )

    def _plane_intersection(self, entry: Table, path: str, handle: str, depth: int) -> Along:
        """Where a plane along the blade meets the suction or pressure side.

        The plane holds the flapwise axis of the root and two points of the reference axis
        (`plane_type1`) or all of it (`plane_type2`); `offset` moves it to the trailing edge.
        """
        rule = self.tables.table(entry, path)
        key = next((k for k in ("plane_type1", "plane_type2") if k in rule), "plane_type1")
        plane = self.tables.table(rule, f"{path}.{key}")
        curve = plane.get("anchor_curve", "reference_axis")
        if curve != "reference_axis":
            message = f"{curve!r} is not evaluated here; expected 'reference_axis'"
            raise self.tables.error(f"{path}.{key}.anchor_curve", message)
        rotation = 0.0
        if plane.get("rotation") is not None:
            rotation = float(self.tables.numbers(plane, f"{path}.{key}.rotation", 1)[0])
        ends = np.array([0.0, 1.0])
        if plane.get("anchors_nd_grid") is not None:
            ends = self.tables.numbers(plane, f"{path}.{key}.anchors_nd_grid", 2)
        side = rule.get("side")
        if side not in ("suction", "pressure", "both"):
            raise self.tables.error(f"{path}.side", "expected suction, pressure or both")
        suction = side == "suction" or (side == "both" and handle == START)
        given = rule.get("offset") is not None
        offset = self.tables.along(rule, f"{path}.offset") if given else STRAIGHT

        def at(r: float) -> float:
            points, s = self._contour(r)
            y0, y1 = (self.sweep.at(float(end)) for end in ends)
            line = y0 + (y1 - y0) * (r - ends[0]) / (ends[1] - ends[0] or 1.0)
            y = (line if key == "plane_type1" else self.sweep.at(r)) - self.sweep.at(r)
            # A positive twist of the file turns the leading edge to the pressure side.
            angle = np.radians(rotation - self.twist.at(r))
            across = np.sin(angle) * points[:, 1] - np.cos(angle) * points[:, 0]
            across -= y + offset.at(r)
            signs = np.flatnonzero(np.diff(np.sign(across)) != 0.0)
            if not signs.size:  # beside the section
                return math.nan
            k = int(signs[0] if suction else signs[-1])
            f = across[k] / (across[k] - across[k + 1])
            return float((s[k] + f * (s[k + 1] - s[k])) / s[-1])

        return self._sampled(path, at, *([offset] if given else []))

    def _sampled(self, path: str, at: Callable[[float], float], *parts: Along) -> Along:
        """A rule along the span, where all its parts are given and it has a result."""
        grid = np.linspace(0.0, 1.0, STEPS + 1)
        for part in parts:
            grid = np.union1d(grid, part.grid)
        grid = np.array([r for r in grid if all(part.covers(float(r)) for part in parts)])
        values = np.array([at(float(r)) for r in grid])
        finite = np.isfinite(values)
        if not finite.any():
            raise self.tables.error(path, "has no result on the span of the blade")
        return Along(grid[finite], values[finite])

    def _contour(self, r: float) -> tuple[Array, Array]:
        if r not in self.contours:
            points = self.contour(r)
            middle = 0.5 * (points[:1] + points[-1:])  # of the face of a flatback
            points = np.vstack([middle, points, middle])
            self.contours[r] = points, lengths_along(points)
        return self.contours[r]
