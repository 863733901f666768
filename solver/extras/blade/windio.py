"""Read the blade of a windIO 2 turbine file: layers, webs, materials, hub."""

import math
import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, nearest
from ...inputs.common.text_file import read_yaml
from ...math.arrays import Array
from ...package.common.plausible import material_doubts
from ...report.section.codes import SectionResults
from .materials import Materials
from .shape import Layer, Shape, check_layers, contour, doubts, read_shape
from .tables import HANDLES, RULES, STRAIGHT, WHOLE, Along, Anchors, Table, Tables

# The hub of a windIO turbine: where the root of a blade is, and its cone.

UPWIND = "upwind"


@dataclass(frozen=True)
class Hub:
    """The place of the root of a blade. A file without a hub: on the axis, without cone."""

    radius: float = 0.0  # [m] from the axis to the root, along the blade
    cone_deg: float = 0.0  # positive: the tip to the pressure side, as upwind rotors have it


NO_HUB = Hub()


def read_hub(table: Mapping[str, Any]) -> Hub:
    """Return the hub of a windIO table; what it does not have, or not as a number, is 0."""
    components, assembly = table["components"], table.get("assembly")
    hub = components.get("hub")
    hub = hub if isinstance(hub, dict) else {}
    orientation = assembly.get("rotor_orientation") if isinstance(assembly, dict) else None
    sign = 1.0 if str(orientation or UPWIND).lower() == UPWIND else -1.0
    return Hub(0.5 * _number(hub.get("diameter")), sign * _number(hub.get("cone_angle")))


def _number(value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        return 0.0
    return number if math.isfinite(number) else 0.0


# Stiffness and mass that a windIO file has itself, beside those of its stations.

DIFFERENT = 0.1  # relative difference that is a finding
# EI about the tension centre and the principal axes: files name the axes of K44 and K55 both ways.
QUANTITIES = {
    "mass": "kg/m",
    "EA": "N",
    "EI flap": "N m2",
    "EI edge": "N m2",
    "GJ": "N m2",
}
BENDING = ("K33", "K34", "K35", "K44", "K45", "K55")


@dataclass(frozen=True)
class Given:
    """`elastic_properties` of a file: mass and stiffnesses along the span; no key: not given."""

    mass: Along | None
    stiffness: dict[str, Along]

    def at(self, r: float) -> dict[str, float]:
        """What the file says at r, of QUANTITIES; without what it does not have there."""
        properties = {}
        if self.mass is not None and self.mass.covers(r):
            properties["mass"] = self.mass.at(r)
        K = {key: one.at(r) for key, one in self.stiffness.items() if one.covers(r)}
        if {"K33", "K44", "K55"} <= K.keys():
            EA, X, Y, XX, XY, YY = (K.get(key, 0.0) for key in BENDING)
            properties |= _bending(np.array([[EA, X, Y], [X, XX, XY], [Y, XY, YY]]))
        if "K66" in K:
            properties["GJ"] = _torsion(K)
        return {key: value for key, value in properties.items() if value > 0.0}


def read_given(tables: Tables, structure: Table) -> Given | None:
    """Return what a file has in `structure.elastic_properties`, None if nothing."""
    if structure.get("elastic_properties") is None:
        return None
    path = "structure.elastic_properties"
    properties = tables.table(structure, path)
    parts: dict[str, dict[str, Along]] = {}
    for part in ("inertia_matrix", "stiffness_matrix"):
        parts[part] = {}
        if properties.get(part) is None:
            continue
        table = tables.table(properties, f"{path}.{part}")
        for key in table:
            if key == "mass" or (part == "stiffness_matrix" and str(key).startswith("K")):
                pair = {key: {"grid": table.get("grid"), "values": table[key]}}
                parts[part][str(key)] = tables.along(pair, f"{path}.{part}.{key}")
    return Given(parts["inertia_matrix"].get("mass"), parts["stiffness_matrix"])


def differences(given: Given, r: float, results: SectionResults) -> list[str]:
    """Return the quantities of a station in which file and section differ, with both numbers.

    Parameters
    ----------
    given : properties of the blade in the file
    r : place along the span, 0 to 1
    results : results of the section
    """
    K = results.K
    ours = {"mass": float(results.M[0, 0]), "GJ": float(1.0 / np.linalg.inv(K)[3, 3])}
    ours |= _bending(K[np.ix_([0, 4, 5], [0, 4, 5])])
    lines = []
    for key, theirs in given.at(r).items():
        ratio = ours[key] / theirs
        if abs(ratio - 1.0) > DIFFERENT:
            lines.append(
                f"{key} {ours[key]:.4g} {QUANTITIES[key]}, elastic_properties {theirs:.4g} "
                f"(x {ratio:.3g})"
            )
    return lines


def _bending(K: Array) -> dict[str, float]:
    """EA, and the principal EI about the tension centre, of a stiffness of tension and bending."""
    EI = K[1:, 1:] - np.outer(K[1:, 0], K[0, 1:]) / K[0, 0] if K[0, 0] > 0.0 else K[1:, 1:]
    flap, edge = np.linalg.eigvalsh(EI).tolist()
    return {"EA": float(K[0, 0]), "EI flap": flap, "EI edge": edge}


def _torsion(K: dict[str, float]) -> float:
    """GJ of a section that is free to warp; K66 where a file has no shear stiffness."""
    full = np.array(
        [[K.get(f"K{min(i, j)}{max(i, j)}", 0.0) for j in range(1, 7)] for i in range(1, 7)]
    )
    if np.linalg.eigvalsh(full)[0] <= 0.0:
        return K["K66"]
    return float(1.0 / np.linalg.inv(full)[5, 5])


# Read the blade of a windIO 2 turbine file: outer shape, layers, webs, materials.
#
# A quantity along the span is a table of `grid` (0 at the root, 1 at the tip) and `values`.
# Positions along the contour are arc lengths from the trailing edge over the suction side and the
# leading edge back to the trailing edge, divided by the whole arc; anchors.py reads them.

HALF = 'if it prints "Blade component could not be converted", its file is not complete'
OLD = ("outer_shape_bem", "internal_structure_2d_fem")
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
LISTS = {
    "structure.layers": (
        "name",
        "material",
        "web",
        "thickness",
        "n_plies",
        "fiber_orientation",
        "start_nd_arc",
        "end_nd_arc",
    ),
    "structure.webs": ("name", "start_nd_arc", "end_nd_arc", "anchors", "flanges"),
    "structure.anchors": ("name", *HANDLES, *RULES),
}
RANGE = ("start_nd_grid", "end_nd_grid")  # of windIO 2.0: the ends of the grid of the thickness


@dataclass(frozen=True)
class Web:
    """A shear web: where its middle meets the shell."""

    name: str
    start: Along  # [-] arc on the suction side
    end: Along  # [-] arc on the pressure side


@dataclass(frozen=True, kw_only=True)
class Blade(Shape):
    """What a file says of the structure of a blade."""

    file: Path
    layers: tuple[Layer, ...] = ()
    webs: tuple[Web, ...] = ()
    materials: dict[str, Table]  # as a section description has them
    span: tuple[float, ...]  # grid of the file's chord
    glue: str = ""  # material of the trailing edge's adhesive; "": the file has none
    hub: Hub = NO_HUB
    given: Given | None = None  # stiffness and mass that the file has itself
    left_out: tuple[str, ...] = ()  # what the file has and the model does not: key and words
    doubtful: tuple[str, ...] = ()  # what is possible, but unlike blades: key and words
    differences: tuple[str, ...] = ()  # between rules of places and their numbers


def read_blade(file: Path) -> Blade:
    """Read a windIO file.

    Raises
    ------
    InputError : it cannot be read, or has no blade of this form; the message names the key.
    """
    top, tables = turbine_table(file), Tables(file)
    blade = tables.table(tables.table(top, "components"), "components.blade")
    if old := [key for key in OLD if key in blade]:
        raise tables.error(
            f"components.blade.{old[0]}",
            "a key of windIO 1; expected a blade of windIO 2: pip install windIO scipy, then "
            f"windio_converter -i {shlex.quote(str(file))} -o ./{shlex.quote(file.stem)}-2.yaml "
            f"({HALF})",
        )
    outer = tables.table(blade, "components.blade.outer_shape")
    structure = tables.table(blade, "components.blade.structure")
    axis = tables.table(blade, "components.blade.reference_axis")
    shape = read_shape(tables, top, outer, axis)
    anchors = Anchors(
        tables, structure, lambda r: contour(shape, r), twist=shape.twist, sweep=shape.sweep
    )
    reader = _Structure(tables, structure, anchors)
    glue = structure.get("trailing_edge_adhesive")
    glue = str(glue.get("material", "")) if isinstance(glue, dict) else ""
    layers = reader.layers()
    materials = Materials(tables, top)
    known = materials.read({glue, *(layer.material for layer in layers)})
    check_layers(tables, shape, layers)
    return Blade(
        **vars(shape),
        file=file,
        layers=layers,
        webs=reader.webs,
        materials=known,
        span=tuple(shape.chord.grid.tolist()),
        glue=glue,
        hub=read_hub(top),
        given=read_given(tables, structure),
        left_out=(*_left_out(tables, structure), *_unknown(tables, outer, structure)),
        doubtful=(
            *doubts(shape),
            *materials.doubts,
            *(doubt.text for doubt in material_doubts(known)),
        ),
        differences=tuple(anchors.differences),
    )


def _unknown(tables: Tables, shape: Table, structure: Table) -> Iterator[str]:
    """Yield keys of outer shape, layers, webs and anchors that windIO does not have.

    Programs write a key into all layers: one line has all entries with the same unknown keys.
    """
    parts: list[tuple[str, Table, tuple[str, ...]]] = [("outer_shape", shape, SHAPE)]
    for path, keys in LISTS.items():
        entries = tables.entries(structure, path)
        parts += [(f"{path}[{i}]", entry, keys) for i, entry in enumerate(entries)]
    groups: dict[tuple[str, ...], list[str]] = {}
    for path, entry, known in parts:
        if unknown := [str(key) for key in entry if key not in known]:
            hints = [nearest(key, known) if key not in RANGE else "" for key in unknown]
            key_texts = [f"{key!r}{hint}" for key, hint in zip(unknown, hints, strict=True)]
            groups.setdefault(tuple(key_texts), []).append(path)
    for names, paths in groups.items():
        more = f" and {len(paths) - 1} more of layers, webs and anchors" if paths[1:] else ""
        yield f"{paths[0]}{more}: unknown key{'s' if names[1:] else ''} {', '.join(names)}"


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


def turbine_table(file: Path) -> Table:
    """Return a windIO file as a table. Raises InputError : no turbine, or unreadable."""
    table = read_yaml(file)
    if not isinstance(table, dict) or "components" not in table:
        raise InputError(f"{file}: components: missing; expected a windIO 2 turbine file")
    return table


class _Structure:
    """Layers and webs, whose places may be those of anchors."""

    def __init__(self, tables: Tables, structure: Table, anchors: Anchors) -> None:
        self.tables, self.structure, self.anchors = tables, structure, anchors

    @cached_property
    def webs(self) -> tuple[Web, ...]:
        read = []
        for i, entry in enumerate(self.tables.entries(self.structure, "structure.webs")):
            path = f"structure.webs[{i}]"
            name = self.tables.text(entry, f"{path}.name")
            start, end = (
                self.anchors.arc(entry, f"{path}.{key}_nd_arc") for key in ("start", "end")
            )
            read.append(Web(name, start, end))
        return tuple(read)

    def layers(self) -> tuple[Layer, ...]:
        entries = self.tables.entries(self.structure, "structure.layers", required=True)
        if not entries:
            message = f"none; expected a layer or more. If windio_converter wrote the file: {HALF}"
            raise self.tables.error("structure.layers", message)
        read = tuple(self._layer(e, f"structure.layers[{i}]") for i, e in enumerate(entries))
        webs = [web.name for web in self.webs]
        for i, layer in enumerate(read):
            path = f"structure.layers[{i}]"
            if layer.web and layer.web not in webs:
                message = f"no web {layer.web!r}{nearest(layer.web, webs)}"
                raise self.tables.error(f"{path}.web", message)
            for other in read[:i]:
                if region_name(other.name) == region_name(layer.name):
                    message = f"{layer.name!r} is the name of another layer, {other.name!r}"
                    raise self.tables.error(f"{path}.name", f"{message}; expected different names")
        return read

    def _layer(self, entry: Table, path: str) -> Layer:
        along = self.tables.along
        angle = entry.get("fiber_orientation") is not None
        web = self.tables.text(entry, f"{path}.web") if entry.get("web") is not None else ""
        # A layer of a web covers all of it, so that it may have no arcs.
        arcs = [f"{path}.{key}_nd_arc" for key in ("start", "end")]
        start, end = WHOLE if web else [self.anchors.arc(entry, arc) for arc in arcs]
        return Layer(
            name=self.tables.text(entry, f"{path}.name"),
            material=self.tables.text(entry, f"{path}.material"),
            thickness=along(entry, f"{path}.thickness"),
            angle=along(entry, f"{path}.fiber_orientation") if angle else STRAIGHT,
            start=start,
            end=end,
            web=web,
        )


def region_name(layer: str) -> str:
    """Return the name of a layer as a region of a mesh."""
    return re.sub(r"[^A-Za-z0-9_-]", "-", layer)
