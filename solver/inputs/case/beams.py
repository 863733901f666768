"""Beam bodies: their specification, and what types and bounds do not tell about them."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...package.body.specification import BeamSpecification
from ..common.table import plain_table
from .beam_lines import division, fractions, is_plain, line_of, line_table
from .beam_schema import BeamBody, BeamStation
from .modes import check_modes
from .schema import Mechanism
from .sections import check_section, given_section, section_spec

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
    stations, sources, found = _stations(key, body, mechanism, folder)
    found += check_motion(key, body)
    if found:
        raise InputError("\n".join(found))
    line = None if is_plain(body) else line_of(body)
    nodes = None if line is None else division(body, line)
    spec: BeamSpecification = {
        "body": name,
        "kind": "beam",
        "length": _length(body),
        "elements": body.elements if nodes is None else len(nodes) - 1,
        "x2_axis": body.x2_axis,
        "section": stations[0][1],
        "theory": body.theory,
        "mass_form": body.mass_form,
        "reference": plain_table(body.reference),
        "modes": [plain_table(mode) for mode in body.modes],
        "damping_ratio": body.damping_ratio,
        "interfaces": {k: plain_table(v) for k, v in body.interfaces.items()},
    }
    if line is not None and nodes is not None:
        spec["line"] = line_table(line, nodes)
    if len(stations) > 1:
        spec["stations"] = [{"at": at, "section": section} for at, section in stations]
    return spec, sources


def with_sections(body: BeamBody) -> list[BeamStation]:
    """Return the stations of a beam, rising, with the section, material and ply angle there."""
    own = {"material": body.material, "ply_angle_deg": body.ply_angle_deg}
    found = []
    for station in body.stations:
        absent = {k: v for k, v in own.items() if getattr(station, k) is None}
        found.append(station.model_copy(update=absent) if station.section is not None else station)
    if all(station.at > 0.0 for station in found):
        first = BeamStation(at=0.0, section=body.section, material=body.material)
        found.insert(0, first.model_copy(update={"ply_angle_deg": body.ply_angle_deg}))
    return sorted(found, key=lambda station: station.at)


def _length(body: BeamBody) -> float:
    return body.length if body.length is not None else line_of(body).length


def _stations(
    key: str, body: BeamBody, mechanism: Mechanism, folder: Path
) -> tuple[list[tuple[float, dict[str, Any]]], list[Path], list[str]]:
    """Return places and sections, files that they are made from, and what is wrong."""
    stations: list[tuple[float, dict[str, Any]]] = []
    sources: list[Path] = []
    found: list[str] = []
    for station in with_sections(body):
        if station.section is None:
            stations.append((station.at, given_section(station)))
            continue
        same = ("section", "material", "ply_angle_deg")
        own = body.model_copy(update={name: getattr(station, name) for name in same})
        wrong = check_section(key, own, mechanism)
        section, files = dict[str, Any](), list[Path]()
        if own.material is not None or not wrong:
            try:
                section, files = section_spec(own, mechanism, folder)
            except InputError as error:
                wrong += str(error).splitlines()
        stations.append((station.at, section))
        sources += files
        found += wrong
    if body.table is not None:
        sources.append(folder / body.table)
    return stations, sources, found


def check_motion(key: str, body: BeamBody) -> list[str]:
    """Return what is wrong with a beam's modes, line, axes and elements; `key` names it."""
    places = fractions(body)
    found = check_modes(key, body.reference, body.modes, places)
    if not body.modes and body.segments == 1:
        found.append(f"{key}.modes: missing; expected at least one")
    x2 = np.array(body.x2_axis)
    if abs(np.linalg.norm(x2) - 1.0) > 1e-9 or abs(x2[0]) > 1e-9:
        found.append(f"{key}.x2_axis = {body.x2_axis}: expected a unit vector normal to body x")
    found += _check_line(key, body)
    at = [station.at for station in body.stations]
    if any(b <= a for a, b in pairwise(at)):
        found.append(f"{key}.stations: at = {at}: expected rising fractions of the length")
    inner = {station.at for station in body.stations if 0.0 < station.at < 1.0}
    least = len({0.0, 1.0, *places.values(), *inner}) - 1
    has_nodes = body.line is not None and body.line.nodes is not None
    if body.elements < max(least, body.segments) and not has_nodes:
        reason = "every interface and station needs a node, every segment an element"
        if not inner and body.segments == 1:
            reason = "every interface needs a node"
        found.append(
            f"{key}.elements = {body.elements}: expected at least {max(least, body.segments)}: "
            f"{reason}"
        )
    if not found and body.reference.kind == "chord" and body.line is not None:
        line = line_of(body)
        for name in body.reference.places:
            (place,) = line.place(np.array([places[name]]))
            if np.abs(place[1:]).max() > ON_AXIS * line.length and body.segments == 1:
                found.append(
                    f"{key}.reference.at: interface {name} is at {place.round(6).tolist()}: "
                    "expected a place on body x, along which a chord runs"
                )
    return found


def _check_line(key: str, body: BeamBody) -> list[str]:
    line, found = body.line, []
    if line is None or line.arc_deg is not None:
        if body.length is None:
            found.append(f"{key}.length: missing; expected the length of the beam")
        if line is not None:
            axis = np.array(line.axis)
            if line.arc_deg == 0.0:
                found.append(f"{key}.line.arc_deg = 0: expected an angle; without `line` straight")
            if not np.linalg.norm(axis) > 0.0 or abs(axis[0]) > 1e-9 * np.linalg.norm(axis):
                found.append(f"{key}.line.axis = {line.axis}: expected a vector normal to body x")
    elif body.length is not None:
        found.append(f"{key}.length = {body.length:g}: expected none, the line has a length")
    if line is not None and line.nodes is not None:
        if len(line.x2_axes or []) != len(line.nodes) - 1:
            found.append(
                f"{key}.line.x2_axes: {len(line.x2_axes or [])} axes; expected one for each of "
                f"{len(line.nodes) - 1} elements"
            )
        if body.twist_deg:
            found.append(f"{key}.twist_deg: expected none, the nodes have axes")
    points = getattr(line, "points", None) or getattr(line, "nodes", None)
    if points and np.linalg.norm(np.diff(np.array(points), axis=0), axis=1).min() == 0.0:
        found.append(f"{key}.line: two neighbouring points are the same")
    at = [pair[0] for pair in body.twist_deg]
    if any(b <= a for a, b in pairwise(at)):
        found.append(f"{key}.twist_deg: expected rising fractions of the length, found {at}")
    spinning = [mode.kind for mode in body.modes if mode.kind.startswith("spinning-")]
    if line is not None and spinning:
        found.append(f'{key}.modes: kind = "{spinning[0]}": expected a straight beam')
    return found
