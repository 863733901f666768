"""Read the blade of a windIO 2 turbine file: outer shape, layers, webs, materials.

A quantity along the span is a table of `grid` (0 at the root, 1 at the tip) and `values`. Positions
along the contour are arc lengths from the trailing edge over the suction side and the leading edge
back to the trailing edge, divided by the whole arc. They are given by the grids of anchors, which
the file has worked out from the rules beside them.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, nearest
from ...math.arrays import Array
from .along import STRAIGHT, WHOLE, Along
from .hub import NO_HUB, Hub, read_hub
from .materials import read_materials
from .tables import Table, Tables

# Keys of windIO 2.1.
SHAPE = (
    "chord",
    "twist",
    "rthick",
    "section_offset_y",
    "section_offset_x",
    "airfoils",
    "surface",
)
LAYER = (
    "name",
    "material",
    "web",
    "thickness",
    "n_plies",
    "fiber_orientation",
    "start_nd_arc",
    "end_nd_arc",
)
WEB = ("name", "start_nd_arc", "end_nd_arc", "anchors", "flanges")


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
    top, tables = _yaml(file), Tables(file)
    blade = tables.table(tables.table(top, "components"), "components.blade")
    if "outer_shape_bem" in blade or "internal_structure_2d_fem" in blade:
        raise tables.error(
            "components.blade",
            "this is a file of windIO 1; expected windIO 2: pip install windIO, then "
            f"windio_converter -i {file.name} -o NEW.yaml",
        )
    shape = tables.table(blade, "components.blade.outer_shape")
    structure = tables.table(blade, "components.blade.structure")
    axis = tables.table(blade, "components.blade.reference_axis")
    reader = _Structure(tables, structure)
    chord = tables.along(shape, "outer_shape.chord")
    if chord.values.min() <= 0.0:
        raise tables.error("outer_shape.chord.values", "expected lengths above 0")

    def optional(parent: Table, path: str) -> Along:
        return tables.along(parent, path) if path.rpartition(".")[2] in parent else STRAIGHT

    glue = structure.get("trailing_edge_adhesive")
    glue = str(glue.get("material", "")) if isinstance(glue, dict) else ""
    layers = reader.layers()
    return Blade(
        file=file,
        length=tables.along(axis, "reference_axis.z"),
        prebend=optional(axis, "reference_axis.x"),
        sweep=optional(axis, "reference_axis.y"),
        chord=chord,
        twist=tables.along(shape, "outer_shape.twist"),
        offset=tables.along(shape, "outer_shape.section_offset_y"),
        thickness=tables.along(shape, "outer_shape.rthick"),
        airfoils=_airfoils(tables, top, shape),
        layers=layers,
        webs=reader.webs,
        materials=read_materials(tables, top, {glue, *(layer.material for layer in layers)}),
        span=tuple(chord.grid.tolist()),
        height=optional(shape, "outer_shape.section_offset_x"),
        glue=glue,
        hub=read_hub(top),
        left_out=(*_left_out(tables, structure), *_unknown(tables, shape, structure)),
    )


def _unknown(tables: Tables, shape: Table, structure: Table) -> Iterator[str]:
    """Yield keys of the outer shape, the layers and the webs that windIO does not have."""
    parts: list[tuple[str, Table, tuple[str, ...]]] = [("outer_shape", shape, SHAPE)]
    for path, keys in (("structure.layers", LAYER), ("structure.webs", WEB)):
        entries = tables.entries(structure, path)
        parts += [(f"{path}[{i}]", entry, keys) for i, entry in enumerate(entries)]
    for path, entry, known in parts:
        for key in entry:
            if key not in known:
                yield f"{path}: unknown key {key!r}{nearest(str(key), known)}"


def _left_out(tables: Tables, structure: Table) -> Iterator[str]:
    """Yield keys with masses or stiffnesses that the stations do not have, and what they mean."""
    for web in tables.entries(structure, "structure.webs"):
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
    joint = structure.get("joint")
    if isinstance(joint, dict) and joint.get("mass"):
        (mass,) = tables.numbers(joint, "structure.joint.mass", 1)
        place = f" at r = {joint['position']}" if "position" in joint else ""
        yield (
            f"structure.joint.mass = {mass:g} kg{place}; a point mass of the case can replace it"
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
    except (yaml.YAMLError, ValueError) as error:
        where = str(error).replace("\n", " ")
        raise InputError(f"{file}: not a YAML file: {where}") from error
    if not isinstance(table, dict) or "components" not in table:
        raise InputError(f"{file}: components: missing; expected a windIO 2 turbine file")
    return table


class _Structure:
    """Layers and webs, whose places may be those of anchors."""

    def __init__(self, tables: Tables, structure: Table) -> None:
        self.tables, self.structure = tables, structure
        self.anchors: dict[str, Table] = {}
        places = [(structure, "structure.anchors")]
        for i, web in enumerate(tables.entries(structure, "structure.webs")):
            places.append((web, f"structure.webs[{i}].anchors"))
        for parent, path in places:
            for i, entry in enumerate(tables.entries(parent, path)):
                self.anchors[tables.text(entry, f"{path}[{i}].name")] = entry

    @cached_property
    def webs(self) -> tuple[Web, ...]:
        found = []
        for i, entry in enumerate(self.tables.entries(self.structure, "structure.webs")):
            path = f"structure.webs[{i}]"
            name = self.tables.text(entry, f"{path}.name")
            start, end = (self._arc(entry, f"{path}.{key}_nd_arc") for key in ("start", "end"))
            found.append(Web(name, start, end))
        return tuple(found)

    def layers(self) -> tuple[Layer, ...]:
        entries = self.tables.entries(self.structure, "structure.layers", required=True)
        found = tuple(self._layer(e, f"structure.layers[{i}]") for i, e in enumerate(entries))
        webs = [web.name for web in self.webs]
        for i, layer in enumerate(found):
            path = f"structure.layers[{i}]"
            if layer.web and layer.web not in webs:
                words = f"no web {layer.web!r}{nearest(layer.web, webs)}"
                raise self.tables.error(f"{path}.web", words)
            for other in found[:i]:
                if region_name(other.name) == region_name(layer.name):
                    words = f"{layer.name!r} is the name of another layer, {other.name!r}"
                    raise self.tables.error(f"{path}.name", f"{words}; expected different names")
        return found

    def _layer(self, entry: Table, path: str) -> Layer:
        along = self.tables.along
        angle = entry.get("fiber_orientation") is not None
        web = self.tables.text(entry, f"{path}.web") if entry.get("web") is not None else ""
        # A layer of a web covers all of it, so that it may have no arcs.
        arcs = [f"{path}.{key}_nd_arc" for key in ("start", "end")]
        start, end = WHOLE if web else [self._arc(entry, arc) for arc in arcs]
        return Layer(
            name=self.tables.text(entry, f"{path}.name"),
            material=self.tables.text(entry, f"{path}.material"),
            thickness=along(entry, f"{path}.thickness"),
            angle=along(entry, f"{path}.fiber_orientation") if angle else STRAIGHT,
            start=start,
            end=end,
            web=web,
        )

    def _arc(self, entry: Table, path: str) -> Along:
        """Position along the contour: given, or that of an anchor."""
        key = path.rpartition(".")[2]
        found = entry.get(key)
        if isinstance(found, dict) and "anchor" in found:
            anchor = self.tables.table(found, f"{path}.anchor")
            name = self.tables.text(anchor, f"{path}.anchor.name")
            key = self.tables.text(anchor, f"{path}.anchor.handle")
            if name not in self.anchors:
                raise self.tables.error(path, f"no anchor {name!r}{nearest(name, self.anchors)}")
            entry = self.anchors[name]
            path = f"structure.anchors.{name}.{key}"
        found = entry.get(key)
        if not isinstance(found, dict) or "grid" not in found:
            raise self.tables.error(
                path,
                "expected numbers in grid and values; rules (plane_intersection, offsets, width, "
                "midpoint) are not evaluated here: let the program that wrote the file do it",
            )
        return self.tables.along({key: found}, path)


def _airfoils(tables: Tables, top: Table, shape: Table) -> tuple[Airfoil, ...]:
    used = tables.entries(shape, "outer_shape.airfoils", required=True)
    names = [tables.text(e, f"outer_shape.airfoils[{i}].name") for i, e in enumerate(used)]
    if not names:
        raise tables.error("outer_shape.airfoils", "expected names of airfoils")
    known = {
        tables.text(entry, f"airfoils[{i}].name"): entry
        for i, entry in enumerate(tables.entries(top, "airfoils", required=True))
    }
    found = []
    for name in dict.fromkeys(names):
        if name not in known:
            raise tables.error("airfoils", f"no airfoil {name!r}{nearest(name, known)}")
        path = f"airfoils.{name}"
        xy = tables.table(known[name], f"{path}.coordinates")
        x, y = (tables.numbers(xy, f"{path}.coordinates.{key}") for key in "xy")
        (thickness,) = tables.numbers(known[name], f"{path}.rthick", 1)
        found.append(Airfoil(name, float(thickness), _ordered(tables, path, x, y)))
    return tuple(found)


def _ordered(tables: Tables, path: str, x: Array, y: Array) -> Array:
    """Points (n, 2) from the trailing edge over the suction side, from either sense."""
    path = f"{path}.coordinates"
    if len(x) != len(y) or len(x) < 10:
        words = f"x has {len(x)} numbers and y {len(y)}; expected as many, ten or more"
        raise tables.error(path, words)
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


def region_name(layer: str) -> str:
    """Return the name of a layer as a region of a mesh."""
    return re.sub(r"[^A-Za-z0-9_-]", "-", layer)
