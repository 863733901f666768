"""The analysed stations: their table, the blade as a body and a case, files of other codes."""

import math
import tempfile
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...errors import InputError, printable
from ...inputs.case.load import load_case
from ...inputs.case.record import CASE_FILE
from ...inputs.case.tables.beam_keys import COLUMNS, TRAPEZE, UPPER
from ...inputs.case.write import write_case
from ...math.arrays import Array
from ...math.laws import lengths_along
from ...package.body.package_file import read_package
from ...package.common.files import write_text
from ...package.common.plain_data import csv_text
from ...package.section.section_file import read_section
from ...package.section.stress import trapeze_strains
from ...report.section.codes import (
    BLADE_AXES_LEADING_EDGE,
    SectionResults,
    read_results,
    transform,
    write_beamdyn,
    write_hawc2,
)
from ...report.table import aligned
from ...workers.packages import build_packages, specs_of
from .layers import StationMesh
from .windio import Blade

# The analysed stations of a blade: which are complete, their table and its text.


@dataclass(frozen=True)
class Station:
    """A station of a blade: its place, its mesh and, if it could be analysed, its numbers."""

    r: float  # [-] 0 at the root, 1 at the tip
    name: str
    mesh: StationMesh
    file: Path  # of its section
    results: SectionResults | None  # None: it has failed


def analysed(
    sections: Path,
    places: Mapping[str, float],
    meshes: Mapping[str, StationMesh],
    failed: Container[str] = (),
) -> list[Station]:
    """Return the stations that have a mesh, with the results of their section files.

    Parameters
    ----------
    sections : folder of the section files
    places : r by name of the station
    meshes : by name of the station
    failed : names of stations that have failed: files of earlier calls do not count
    """
    stations = []
    for name, mesh in meshes.items():
        file = sections / name / f"{name}.vtkhdf"
        results = None if name in failed else read_results(file)
        stations.append(Station(places[name], name, mesh, file, results))
    return stations


def complete(stations: Sequence[Station]) -> list[Station]:
    """Return the stations that could be analysed."""
    return [station for station in stations if station.results is not None]


def station_csv(blade: Blade, stations: list[Station]) -> str:
    """Return the table of all complete stations."""
    head = ["r", "z_m", "chord_m", "twist_deg", "mass_kg_m", "removed"]
    head += [f"{letter}{i + 1}{j + 1}" for letter in "KM" for i, j in UPPER]
    rows: list[list[object]] = [list(head)]
    for station in stations:
        r, one = station.r, station.results
        if one is None:
            continue
        row = [r, blade.length.at(r), blade.chord.at(r), blade.twist.at(r), float(one.M[0, 0])]
        row += [station.mesh.removed, *(K[i, j] for K in (one.K, one.M) for i, j in UPPER)]
        rows.append([float(value) for value in row])
    return csv_text(rows)


def station_text(blade: Blade, stations: list[Station]) -> str:
    """Return what the screen shows of the stations."""
    rows = [
        ["r", "z", "chord", "mass", "EA", "EI flap", "EI edge", "GJ"],
        ["[-]", "[m]", "[m]", "[kg/m]", "[N]", "[N m2]", "[N m2]", "[N m2]"],
    ]
    for station in stations:
        r = station.r
        if station.results is None:
            rows.append([f"{r:.4f}", "failed", *[""] * 6])
            continue
        K, M = station.results.K, station.results.M
        place = [f"{r:.4f}", f"{blade.length.at(r):.3f}", f"{blade.chord.at(r):.3f}"]
        rows.append([*place, f"{M[0, 0]:.2f}", *(f"{K[i, i]:.3e}" for i in (0, 4, 5, 3))])
    return aligned(rows, (), rule=False)


# Estimated errors of the frequencies of a blade: of its sections, stations and elements.
#
# The clamped blade is computed again with another table or with fewer elements: with every second
# station, with stiffnesses that are lower by the error estimate of the sections, and with half of
# the elements. Errors of the elements fall with the square of their length, those of the stations
# about linearly with their distance (docs/blade.md), because lay-up and shape change within a few
# of them.

AS_IT_IS, SECTIONS, STATIONS, ELEMENTS = "blade", "sections", "stations", "elements"
COUNT = 6
# Error over the change when half of the stations or elements are left out.
SHARES = {SECTIONS: 1.0, STATIONS: 1.5, ELEMENTS: 1.0 / 3.0}

BODY = """
[bodies.{name}]
kind = "beam"
table = "{name}.csv"
elements = {elements}
modes = [{{ kind = "lowest", count = {count} }}]
interfaces = {{ root = {{ at = "start" }} }}

[joints.{name}]
kind = "fixed"
between = ["ground.hub", "{name}.root"]
"""
ERRORS_HEAD = """\
format = 1
title = "Errors of frequencies"

[ground.hub]
position = [0.0, 0.0, 0.0]

[solver]
t_end = 1.0
output_step = 1.0

[runs.all]
"""


def frequencies_at_rest(
    blade: Blade, stations: Sequence[Station]
) -> tuple[Array, dict[str, Array]]:
    """Return the lowest frequencies [Hz] of the clamped blade, and their relative errors by cause.

    A cause that cannot be estimated is left out: of the sections without their estimates, of the
    stations if there are fewer than three.
    """
    known = complete(stations)
    elements = elements_of(len(known))
    tables = {AS_IT_IS: (known, elements), ELEMENTS: (known, elements // 2)}
    if softer := _softer(known):
        tables[SECTIONS] = (softer, elements)
    if len(known) > 2:
        fewer = [*known[:-1:2], known[-1]]
        tables[STATIONS] = (fewer, max(elements, 2 * (len(fewer) - 1)))
    frequencies = _computed(blade, tables)
    own = frequencies.pop(AS_IT_IS)
    errors = {name: SHARES[name] * np.abs(w / own - 1.0) for name, w in frequencies.items()}
    return own, errors


def _softer(stations: Sequence[Station]) -> list[Station]:
    """The stations with K lowered by its estimate; none if one has no estimate."""
    softened = []
    for station in stations:
        one = station.results
        if one is None or one.error_estimate is None:
            return []
        K = one.K - np.diag(np.diag(one.error_estimate))
        if np.linalg.eigvalsh(K)[0] <= 0.0:
            return []
        softened.append(replace(station, results=replace(one, K=K)))
    return softened


def _computed(
    blade: Blade, tables: Mapping[str, tuple[Sequence[Station], int]]
) -> dict[str, Array]:
    """Frequencies [Hz] of clamped beams by name."""
    with tempfile.TemporaryDirectory(prefix="plymotion-") as temporary:
        folder = Path(temporary)
        text = ERRORS_HEAD
        for name, (stations, elements) in tables.items():
            write_text(folder / f"{name}.csv", body_csv(blade, stations))
            text += BODY.format(name=name, elements=elements, count=COUNT)
        write_text(folder / CASE_FILE, text)
        write_case(load_case(folder / CASE_FILE), folder / "out")
        bodies = folder / "out" / "bodies"
        build_packages(specs_of(folder / "out", ["all"]), bodies)
        files = {name: next(bodies.glob(f"{name}*.vtkhdf")) for name in tables}
        return {
            name: read_package(file).frequencies[:COUNT] / (2.0 * np.pi)
            for name, file in files.items()
        }


def error_text(frequencies: Array, errors: dict[str, Array]) -> str:
    """Return the table that the screen shows."""
    names = [name for name in SHARES if name in errors]
    lines = [
        "Frequencies of the clamped blade at rest, and their estimated errors:",
        f"{'mode':>4}  {'[Hz]':>9}" + "".join(f"  {name:>9}" for name in names),
    ]
    for k, f in enumerate(frequencies):
        cells = "".join(f"  {100.0 * errors[name][k]:8.2g}%" for name in names)
        lines.append(f"{k + 1:4d}  {f:9.5g}{cells}")
    return "\n".join(lines)


def error_csv(frequencies: Array, errors: dict[str, Array]) -> str:
    """Return the same numbers as a file."""
    names = [name for name in SHARES if name in errors]
    lines = [",".join(["mode", "frequency_hz", *(f"error_{name}" for name in names)])]
    for k, f in enumerate(frequencies):
        values = (f, *(errors[name][k] for name in names))
        lines.append(",".join([str(k + 1), *(repr(float(v)) for v in values)]))
    return "\n".join([*lines, ""])


# The blade as a beam body: a table of its stations that the case of a mechanism reads.
#
# Body axes: x along the pitch axis to the tip, y to the leading edge, z to the suction side, of a
# section without twist; in windIO's axes z, -y and x.

BODY_HEAD = """\
# Beam body of {name}, written by `plymotion blade`. In a case:
#   [bodies.blade]
#   kind = "beam"
#   table = "beam.csv"
# Body axes: x along the pitch axis to the tip, y to the leading edge, z to the suction side.
# Sections: x1 along the line, x2 to the leading edge, x3 to the suction side.
# K stiffness [N, N m, N m2] and M mass per length [kg/m, kg, kg m], both about the line.
# A1 ... A6: second-order strains of a twisted section (trapeze effect).
"""


def line_of(blade: Blade, places: Sequence[float]) -> Array:
    """Return points (n, 3) of the reference axis at r, in body axes [m]."""
    r = np.array(places)
    return np.column_stack(
        [blade.length.smooth(r), -blade.sweep.smooth(r), blade.prebend.smooth(r)]
    )


def body_csv(blade: Blade, stations: Sequence[Station]) -> str:
    """Return the table of a beam body from the complete stations.

    A positive twist of the file turns the leading edge to the pressure side, which is a negative
    rotation about x.
    """
    complete = [(s, s.results) for s in stations if s.results is not None]
    rows: list[list[object]] = [[*COLUMNS, *TRAPEZE]]
    points = line_of(blade, [station.r for station, _ in complete])
    for (station, one), point in zip(complete, points, strict=True):
        row = [*point, -blade.twist.at(station.r)]
        row += [A[i, j] for A in (one.K, one.M) for i, j in UPPER]
        row += [*trapeze_strains(one.K, read_section(station.file).recovery)]
        rows.append([float(value) + 0.0 for value in row])
    return BODY_HEAD.format(name=blade.file.name) + csv_text(rows)


LEAST_ELEMENTS = 60  # at least, of a blade


def elements_of(stations: int) -> int:
    """Elements of a blade: equally many between its stations, an even number."""
    between = max(stations - 1, 1)
    return between * 2 * max(1, math.ceil(0.5 * LEAST_ELEMENTS / between))


# Blade files of other codes: stiffness, mass and geometry for BeamDyn and HAWC2.


def write_for(code: str, blade: Blade, stations: Sequence[Station], folder: Path) -> list[Path]:
    """Write the files of a blade for another code; returns them.

    Parameters
    ----------
    code : one of OF_BLADES
    stations : from root to tip; those that have failed are left out

    Raises
    ------
    InputError : fewer than two complete stations.
    """
    usable = [(s.r, s.results) for s in stations if s.results is not None]
    if len(usable) < 2:
        raise InputError(f"blade: --to {code}: expected two complete stations or more")
    places, results = [r for r, _ in usable], [one for _, one in usable]
    writer = _beamdyn if code == "beamdyn" else _hawc2
    return writer(blade, places, results, folder)


def _beamdyn(
    blade: Blade, places: list[float], results: list[SectionResults], folder: Path
) -> list[Path]:
    """Matrices about the reference axis, and the key points of the primary input file."""
    points = line_of(blade, places)
    x, y, z = points.T
    file = write_beamdyn(
        folder / "blade_beamdyn.dat",
        lengths_along(points).tolist(),
        [one.K for one in results],
        [one.M for one in results],
        title=blade.file.stem,
        blade_axes=BLADE_AXES_LEADING_EDGE,
    )
    title = printable(blade.file.stem)
    lines = [
        f"          1   member_total    - Total number of members (-)  [{title}]",
        f"{len(x):11d}   kp_total        - Total number of key points (-) [must be at least 3]",
        f"     1 {len(x):4d}                 - Member number; Number of key points in this member",
        "\t\t kp_xr \t\t\t kp_yr \t\t\t kp_zr \t\t initial_twist",
        "\t\t  (m)  \t\t\t  (m)  \t\t\t  (m)  \t\t   (deg)",
    ]
    for r, *point in zip(places, z, -y, x, strict=True):
        lines.append("  ".join(f"{value: .10E}" for value in (*point, blade.twist.at(r))))
    keys = folder / "blade_beamdyn_geometry.dat"
    write_text(keys, "\n".join(lines) + "\n")
    return [file, keys]


def _hawc2(
    blade: Blade, places: list[float], results: list[SectionResults], folder: Path
) -> list[Path]:
    """Matrices about the half-chord line, and its c2_def: x to the leading edge, z to the tip."""
    to_middle = np.array(
        [[blade.offset.at(r) - 0.5 * blade.chord.at(r), blade.height.at(r)] for r in places]
    )
    twist = -np.radians([blade.twist.at(r) for r in places])
    c, s = np.cos(twist), np.sin(twist)
    middle = line_of(blade, places)
    middle[:, 1] += c * to_middle[:, 0] - s * to_middle[:, 1]
    middle[:, 2] += s * to_middle[:, 0] + c * to_middle[:, 1]
    file = write_hawc2(
        folder / "blade_hawc2_st.dat",
        lengths_along(middle).tolist(),
        [transform(one.K, d) for one, d in zip(results, to_middle, strict=True)],
        [transform(one.M, d, kind="mass") for one, d in zip(results, to_middle, strict=True)],
        title=blade.file.stem,
    )
    lines = ["begin c2_def ;", f"  nsec {len(places)} ;"]
    for k, (x, y, z) in enumerate(middle):
        values = " ".join(f"{value: .8e}" for value in (y, z, x, np.degrees(twist[k])))
        lines.append(f"  sec {k + 1} {values} ;")
    geometry = folder / "blade_hawc2_c2_def.htc"
    write_text(geometry, "\n".join([*lines, "end c2_def ;", ""]))
    return [file, geometry]
