"""Beam bodies: reference line, cross-sections, specification, checks beyond types and bounds.

Between its nodes an element is straight. Its section axes are those of the line in its middle:
x1 along the element, x2 carried along the line without rotation about it (parallel transport) and
then rotated about it by `twist_deg`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import cast

import numpy as np

from ....errors import InputError, collected, refuse, under
from ....math.arrays import Array
from ....math.laws import lengths_along
from ....math.rotations import shortest_rotations, vector_to_matrix
from ....package.common.cells import node_positions
from ....package.specification import BeamSpecification, LineTable, PlyTable
from ...common.materials import plain
from ...common.mesh_files import ALL
from ...section.description import Region
from ...section.shapes.library import walls
from ...section.specification import section_spec as described_section
from ...section.specification import shape_mesh, source_files
from ..tables.beam_keys import BeamBody, BeamStation, Spline
from ..tables.bodies import DescribedSection, check_modes
from ..tables.schema import Mechanism
from .descriptions import INLINE, reduction, section_table

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


def division(body: BeamBody) -> Array:
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


def section_spec(
    station: BeamStation, mechanism: Mechanism, folder: Path
) -> tuple[dict[str, object], list[Path]]:
    """Return the specification of the section of a station, and the files that it is made from.

    Parameters
    ----------
    station : has passed `check_section`
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        Lines that begin with the key: what is wrong with the section.
    """
    assert station.section is not None
    key = f"sections.{station.section}"
    table = mechanism.sections[station.section]
    if isinstance(table, DescribedSection):
        return _described(key, station.section, table, mechanism, folder)
    assert station.material is not None
    ply: PlyTable = {"material": station.material, "angle_deg": station.ply_angle_deg or 0.0}
    region = Region(material=station.material)
    mesh, regions = shape_mesh(table, {ALL: region}, {ALL: [ply]}, folder, where=key)
    if table.degree is not None:
        mesh["degree"] = table.degree
    spec: dict[str, object] = {
        "name": station.section,
        "convention": "contour",
        "mesh": mesh,
        "materials": {station.material: plain(mechanism.materials[station.material])},
        "regions": regions,
    }
    return spec, []


def given_section(station: BeamStation) -> dict[str, object]:
    """Return the specification of a station with matrices of its own."""
    return {
        "name": f"at {station.at:.4f}",
        "stiffness": station.stiffness,
        "mass": station.mass,
        "trapeze": station.trapeze,
    }


def check_section(key: str, station: BeamStation, mechanism: Mechanism) -> list[str]:
    """Return what does not fit between a body and its section; `key` names the station.

    Parameters
    ----------
    key : key of the input file, for messages
    station : station of the beam with its section
    mechanism : tables of the case, checked for types and bounds
    """
    assert station.section is not None
    table = mechanism.sections[station.section]
    given = {"material": station.material, "ply_angle_deg": station.ply_angle_deg}
    if isinstance(table, DescribedSection):
        return [
            f"{key}.{name} = {value}: expected no such key, section {station.section} has its own "
            f"materials and angles ({table.file or INLINE})"
            for name, value in given.items()
            if value is not None
        ]
    if station.material is None:
        return [f"{key}.material: missing; expected the material of section {station.section}"]
    plane = all(w.direction == {"vector": [1.0, 0.0]} for w in walls(table.shape, table.values))
    if station.ply_angle_deg and not plane:
        return [
            f"{key}.ply_angle_deg = {station.ply_angle_deg:g}: expected 0, a {table.shape} has "
            "walls in several directions: describe it in a file, sections.NAME.file"
        ]
    return []


def _described(
    key: str, name: str, section: DescribedSection, mechanism: Mechanism, folder: Path
) -> tuple[dict[str, object], list[Path]]:
    file = folder / INLINE
    try:
        table, file = section_table(name, section, mechanism, folder)
        spec = described_section(table, file)
    except InputError as error:
        if section.file is not None:
            raise under(f"{key}.file", error) from error
        bare = (line.removeprefix(f"{file}: ") for line in str(error).splitlines())
        raise InputError("\n".join(f"{key}.{INLINE}.{line}" for line in bare)) from error
    del spec["title"]  # another title is no other body
    return {**spec, "name": name}, source_files(table, file)[section.file is None :]


ON_AXIS = 1e-9  # of the length: distance of an interface from the x axis that is round-off


def beam_spec(
    name: str, body: BeamBody, mechanism: Mechanism, folder: Path
) -> tuple[BeamSpecification, list[Path]]:
    """Return the specification of a beam and the files beside the case file that it is made from.

    Parameters
    ----------
    body : its sections and materials exist
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        What is wrong with the body, one line each.
    """
    key = f"bodies.{name}"
    stations, sources, errors = _stations(key, body, mechanism, folder)
    errors += check_motion(key, body)
    refuse(errors)
    line = None if is_plain(body) else line_of(body)
    nodes = None if line is None else division(body)
    own = {
        "body": name,
        "kind": "beam",
        "length": _length(body),
        "elements": body.elements if nodes is None else len(nodes) - 1,
        "x2_axis": body.x2_axis,
        "section": stations[0][1],
        "theory": body.theory,
        "mass_form": body.mass_form,
    }
    spec = cast(BeamSpecification, {**own, **reduction(body)})
    if line is not None and nodes is not None:
        spec["line"] = line_table(line, nodes)
    if len(stations) > 1:
        spec["stations"] = [{"at": at, "section": section} for at, section in stations]
    return spec, sources


def with_sections(body: BeamBody) -> list[BeamStation]:
    """Return the stations of a beam, rising, with the section, material and ply angle there."""
    own = {"material": body.material, "ply_angle_deg": body.ply_angle_deg}
    stations = []
    for station in body.stations:
        absent = {k: v for k, v in own.items() if getattr(station, k) is None}
        stations.append(
            station.model_copy(update=absent) if station.section is not None else station
        )
    if all(station.at > 0.0 for station in stations):
        first = BeamStation(
            at=0.0,
            section=body.section,
            material=body.material,
            ply_angle_deg=body.ply_angle_deg,
        )
        stations.insert(0, first)
    return sorted(stations, key=lambda station: station.at)


def _length(body: BeamBody) -> float:
    return body.length if body.length is not None else line_of(body).length


def _stations(
    key: str, body: BeamBody, mechanism: Mechanism, folder: Path
) -> tuple[list[tuple[float, dict[str, object]]], list[Path], list[str]]:
    """Return places and sections, files that they are made from, and what is wrong."""
    stations: list[tuple[float, dict[str, object]]] = []
    sources: list[Path] = []
    errors: list[str] = []
    for station in with_sections(body):
        if station.section is None:
            stations.append((station.at, given_section(station)))
            continue
        wrong = check_section(key, station, mechanism)
        section, files = dict[str, object](), list[Path]()
        if station.material is not None or not wrong:
            with collected(wrong):
                section, files = section_spec(station, mechanism, folder)
        stations.append((station.at, section))
        sources += files
        errors += wrong
    if body.table is not None:
        sources.append(folder / body.table)
    return stations, sources, errors


def check_motion(key: str, body: BeamBody) -> list[str]:
    """Return what is wrong with a beam's modes, line, axes and elements; `key` names it."""
    places = fractions(body)
    errors = check_modes(key, body.reference, body.modes, places)
    if not body.modes and body.segments == 1:
        errors.append(f"{key}.modes: missing; expected at least one")
    x2 = np.array(body.x2_axis)
    if abs(np.linalg.norm(x2) - 1.0) > 1e-9 or abs(x2[0]) > 1e-9:
        errors.append(f"{key}.x2_axis = {body.x2_axis}: expected a unit vector normal to body x")
    errors += _check_line(key, body)
    at = [station.at for station in body.stations]
    if any(b <= a for a, b in pairwise(at)):
        errors.append(f"{key}.stations: at = {at}: expected rising fractions of the length")
    inner = {station.at for station in body.stations if 0.0 < station.at < 1.0}
    least = len({0.0, 1.0, *places.values(), *inner}) - 1
    has_nodes = body.line is not None and body.line.nodes is not None
    if body.elements < max(least, body.segments) and not has_nodes:
        reason = "every interface and station needs a node, every segment an element"
        if not inner and body.segments == 1:
            reason = "every interface needs a node"
        errors.append(
            f"{key}.elements = {body.elements}: expected at least {max(least, body.segments)}: "
            f"{reason}"
        )
    if not errors and body.reference.kind == "chord" and body.line is not None:
        line = line_of(body)
        for name in body.reference.places:
            (place,) = line.place(np.array([places[name]]))
            if np.abs(place[1:]).max() > ON_AXIS * line.length and body.segments == 1:
                errors.append(
                    f"{key}.reference.at: interface {name} is at {place.round(6).tolist()}: "
                    "expected a place on body x, along which a chord runs"
                )
    return errors


def _check_line(key: str, body: BeamBody) -> list[str]:
    line, errors = body.line, []
    if line is None or line.arc_deg is not None:
        if body.length is None:
            errors.append(f"{key}.length: missing; expected the length of the beam")
        if line is not None:
            axis = np.array(line.axis)
            if line.arc_deg == 0.0:
                errors.append(f"{key}.line.arc_deg = 0: expected an angle; without `line` straight")
            if not np.linalg.norm(axis) > 0.0 or abs(axis[0]) > 1e-9 * np.linalg.norm(axis):
                errors.append(f"{key}.line.axis = {line.axis}: expected a vector normal to body x")
    elif body.length is not None:
        errors.append(f"{key}.length = {body.length:g}: expected none, the line has a length")
    if line is not None and line.nodes is not None:
        if len(line.x2_axes or []) != len(line.nodes) - 1:
            errors.append(
                f"{key}.line.x2_axes: {len(line.x2_axes or [])} axes; expected one for each of "
                f"{len(line.nodes) - 1} elements"
            )
        if body.twist_deg:
            errors.append(f"{key}.twist_deg: expected none, the nodes have axes")
    points = getattr(line, "points", None) or getattr(line, "nodes", None)
    if points and np.linalg.norm(np.diff(np.array(points), axis=0), axis=1).min() == 0.0:
        errors.append(f"{key}.line: two neighbouring points are the same")
    at = [pair[0] for pair in body.twist_deg]
    if any(b <= a for a, b in pairwise(at)):
        errors.append(f"{key}.twist_deg: expected rising fractions of the length, found {at}")
    spinning = [mode.kind for mode in body.modes if mode.kind.startswith("spinning-")]
    if line is not None and spinning:
        errors.append(f'{key}.modes: kind = "{spinning[0]}": expected a straight beam')
    return errors
