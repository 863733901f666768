"""Read the blade of a windIO 2 turbine file: outer shape, layers, webs, materials.

A quantity along the span is a table of `grid` (0 at the root, 1 at the tip) and `values`. Positions
along the contour are arc lengths from the trailing edge over the suction side and the leading edge
back to the trailing edge, divided by the whole arc. They are given by the grids of anchors, which
the file has worked out from the rules beside them.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...errors import InputError, nearest
from ...math.arrays import Array
from .hub import NO_HUB, Hub, read_hub

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
class Web:
    """A shear web: where its middle meets the shell."""

    name: str
    start: Along  # [-] arc on the suction side
    end: Along  # [-] arc on the pressure side


@dataclass(frozen=True)
class Airfoil:
    """Coordinates over the chord, from the trailing edge over the suction side."""

    name: str
    thickness: float  # largest over the chord
    points: Array  # (n, 2)


@dataclass(frozen=True)
class Blade:
    """What a file says of the structure of a blade."""

    file: Path
    length: Along  # [m] coordinate z along the reference axis
    prebend: Along  # [m] its x, to the suction side
    sweep: Along  # [m] its y, to the trailing edge
    chord: Along  # [m]
    twist: Along  # [deg]
    offset: Along  # [m] from the leading edge to the reference axis along the chord
    thickness: Along  # [-] over the chord
    airfoils: tuple[Airfoil, ...]
    layers: tuple[Layer, ...]
    webs: tuple[Web, ...]
    materials: dict[str, dict[str, Any]]  # as a section description has them
    span: tuple[float, ...]  # grid of the file's chord
    height: Along = STRAIGHT  # [m] of the chord line over the reference axis, to the suction side
    glue: str = ""  # material of the trailing edge's adhesive; "": the file has none
    hub: Hub = NO_HUB
    left_out: tuple[str, ...] = ()  # what the file has and the model does not: key and words


def read_blade(file: Path) -> Blade:
    """Read a windIO file.

    Raises
    ------
    InputError : it cannot be read, or has no blade of this form; the message names the key.
    """
    table = _yaml(file)
    reader = _Reader(file, table)
    blade = reader.table(reader.table(table, "components"), "components.blade")
    shape = reader.table(blade, "components.blade.outer_shape")
    structure = reader.table(blade, "components.blade.structure")
    axis = reader.table(blade, "components.blade.reference_axis")
    anchors = reader.anchors(structure)
    chord = reader.along(shape, "chord", "outer_shape")
    webs = tuple(
        Web(
            str(entry.get("name")),
            reader.arc(entry, "start_nd_arc", anchors, f"webs[{i}]"),
            reader.arc(entry, "end_nd_arc", anchors, f"webs[{i}]"),
        )
        for i, entry in enumerate(structure.get("webs") or [])
    )
    layers = tuple(reader.layer(e, i, anchors) for i, e in enumerate(structure["layers"]))
    reader.differ([layer.name for layer in layers])
    return Blade(
        file=file,
        length=reader.along(axis, "z", "reference_axis"),
        prebend=reader.along(axis, "x", "reference_axis") if "x" in axis else STRAIGHT,
        sweep=reader.along(axis, "y", "reference_axis") if "y" in axis else STRAIGHT,
        chord=chord,
        twist=reader.along(shape, "twist", "outer_shape"),
        offset=reader.along(shape, "section_offset_y", "outer_shape"),
        thickness=reader.along(shape, "rthick", "outer_shape"),
        airfoils=reader.airfoils(shape),
        layers=layers,
        webs=webs,
        materials={str(m["name"]): _material(m) for m in table.get("materials", [])},
        span=tuple(chord.grid.tolist()),
        height=reader.along(shape, "section_offset_x", "outer_shape")
        if "section_offset_x" in shape
        else STRAIGHT,
        glue=str((structure.get("trailing_edge_adhesive") or {}).get("material", "")),
        hub=read_hub(table),
        left_out=tuple(_left_out(structure)),
    )


def _left_out(structure: Mapping[str, Any]) -> Iterator[str]:
    """Yield keys with masses or stiffnesses that the stations do not have, and what they mean."""
    for web in structure.get("webs") or []:
        if web.get("flanges"):
            yield (
                f"structure.webs: {web.get('name')}: flanges: the bond line between web and shell; "
                "the web ends at the inner face of the shell"
            )
    if structure.get("trailing_edge_adhesive"):
        yield (
            "structure.trailing_edge_adhesive: its area between four anchors; a sharp edge is "
            "closed by a plate of this material, 0.4 % of the chord thick"
        )
    joint = structure.get("joint") or {}
    if joint.get("mass"):
        yield (
            f"structure.joint.mass = {joint['mass']:g} kg at r = {joint.get('position', 0.0):g}; "
            "a point mass of the case can take its place"
        )


def _yaml(file: Path) -> dict[str, Any]:
    try:
        import yaml
    except ImportError as error:
        raise InputError("plymotion blade needs PyYAML: pip install 'plymotion[blade]'") from error
    try:
        with file.open(encoding="utf-8") as stream:
            table = yaml.load(stream, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file}: cannot be read: {error}") from error
    except yaml.YAMLError as error:
        where = str(error).replace("\n", " ")
        raise InputError(f"{file}: not a YAML file: {where}") from error
    if not isinstance(table, dict) or "components" not in table:
        raise InputError(f"{file}: components: missing; expected a windIO 2 turbine file")
    return table


class _Reader:
    def __init__(self, file: Path, table: Mapping[str, Any]) -> None:
        self.file, self.top = file, table

    def error(self, key: str, words: str) -> InputError:
        return InputError(f"{self.file}: {key}: {words}")

    def table(self, parent: Mapping[str, Any], path: str) -> dict[str, Any]:
        key = path.rpartition(".")[2]
        found = parent.get(key)
        if not isinstance(found, dict):
            known = [str(name) for name in parent]
            raise self.error(path, f"missing; expected a table of windIO 2{nearest(key, known)}")
        return found

    def along(self, parent: Mapping[str, Any], key: str, where: str) -> Along:
        found = parent.get(key)
        if not isinstance(found, dict) or not {"grid", "values"} <= found.keys():
            raise self.error(f"{where}.{key}", "missing; expected a table with grid and values")
        return self.pairs(found, f"{where}.{key}")

    def pairs(self, found: Mapping[str, Any], where: str) -> Along:
        try:
            grid = np.array(found["grid"], dtype=float)
            values = np.array(found["values"], dtype=float)
        except (TypeError, ValueError) as error:
            raise self.error(where, "expected numbers in grid and values") from error
        if grid.ndim != 1 or grid.shape != values.shape or not len(grid):
            raise self.error(where, f"grid has {grid.size} numbers and values {values.size}")
        if not np.isfinite([grid, values]).all() or (np.diff(grid) < 0).any():
            raise self.error(where, "expected finite numbers, and a grid that rises")
        return Along(grid, values)

    def anchors(self, structure: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
        """Anchors by name: those of the structure, and those of the webs."""
        found: dict[str, Mapping[str, Any]] = {}
        webs = structure.get("webs") or []
        for entry in [*(structure.get("anchors") or []), *(a for w in webs for a in w["anchors"])]:
            found[str(entry["name"])] = entry
        return found

    def arc(
        self, entry: Mapping[str, Any], key: str, anchors: Mapping[str, Any], where: str
    ) -> Along:
        """Position along the contour: given, or that of an anchor."""
        found = entry.get(key)
        where = f"structure.{where}.{key}"
        if isinstance(found, dict) and "anchor" in found:
            name, handle = found["anchor"]["name"], found["anchor"]["handle"]
            if name not in anchors:
                raise self.error(where, f"no anchor {name!r}{nearest(str(name), anchors)}")
            found = anchors[name].get(handle)
            where = f"structure.anchors.{name}.{handle}"
        if not isinstance(found, dict) or "grid" not in found:
            words = "expected grid and values; let the program that made the file work them out"
            raise self.error(where, words)
        return self.pairs(found, where)

    def layer(self, entry: Mapping[str, Any], i: int, anchors: Mapping[str, Any]) -> Layer:
        where = f"layers[{i}]"
        angle = entry.get("fiber_orientation")
        return Layer(
            name=str(entry.get("name", i)),
            material=str(entry.get("material")),
            thickness=self.along(entry, "thickness", f"structure.{where}"),
            angle=self.pairs(angle, where) if angle else Along(np.zeros(1), np.zeros(1)),
            start=self.arc(entry, "start_nd_arc", anchors, where),
            end=self.arc(entry, "end_nd_arc", anchors, where),
            web=str(entry.get("web") or ""),
        )

    def differ(self, names: Sequence[str]) -> None:
        """Refuse layers that would be one region of the mesh."""
        for i, name in enumerate(names):
            known = {region_name(other): other for other in names[:i]}
            if region_name(name) in known:
                other = known[region_name(name)]
                words = f"{name!r} is the name of another layer, {other!r}"
                raise self.error(
                    f"structure.layers[{i}].name", f"{words}; expected names that differ"
                )

    def airfoils(self, shape: Mapping[str, Any]) -> tuple[Airfoil, ...]:
        names = [str(entry["name"]) for entry in shape.get("airfoils") or []]
        tables = {str(a.get("name")): a for a in self.top.get("airfoils", [])}
        if missing := [name for name in names if name not in tables]:
            raise self.error("airfoils", f"no airfoil {missing[0]!r}{nearest(missing[0], tables)}")
        if not names:
            raise self.error("outer_shape.airfoils", "missing; expected names of airfoils")
        found = []
        for name in dict.fromkeys(names):
            xy = tables[name]["coordinates"]
            points = np.column_stack([np.array(xy["x"], float), np.array(xy["y"], float)])
            if not np.isfinite(points).all() or len(points) < 10:
                raise self.error(f"airfoils.{name}.coordinates", "expected ten points or more")
            found.append(Airfoil(name, float(tables[name]["rthick"]), points))
        return tuple(found)


def region_name(layer: str) -> str:
    """Return the name of a layer as a region of a mesh."""
    return re.sub(r"[^A-Za-z0-9_-]", "-", layer)


def _material(entry: Mapping[str, Any]) -> dict[str, Any]:
    """A material as a section description has it."""
    if not entry.get("orth"):
        found: dict[str, Any] = {"kind": "isotropic", "E": float(entry["E"]), "nu": entry["nu"]}
        found["rho"] = float(entry["rho"])
        return found
    E, G, nu = (_three(entry[key]) for key in ("E", "G", "nu"))
    found = {"kind": "orthotropic", "rho": float(entry["rho"])}
    found |= dict(zip(("E1", "E2", "E3"), E, strict=True))
    found |= dict(zip(("G12", "G13", "G23"), G, strict=True))
    found |= dict(zip(("nu12", "nu13", "nu23"), nu, strict=True))
    if all(isinstance(entry.get(key), list) for key in ("Xt", "Xc", "S")):
        Xt, Xc, S = (_three(entry[key]) for key in ("Xt", "Xc", "S"))
        values = (Xt[0], Xc[0], Xt[1], Xc[1], S[0])
        if all(math.isfinite(value) and value > 0.0 for value in values):
            found["strength"] = dict(zip(("Xt", "Xc", "Yt", "Yc", "S12"), values, strict=True))
    return found


def _three(values: Sequence[float]) -> list[float]:
    return [float(value) for value in values]
