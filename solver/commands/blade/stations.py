"""The analysed stations of a blade: which are complete, their table and its text."""

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..section.results import SectionResults, read_results
from ..section.summary import UPPER
from .cells import StationMesh
from .windio import Blade


@dataclass(frozen=True)
class Station:
    """A station of a blade: its place, its mesh and, if it could be analysed, its numbers."""

    r: float  # [-] 0 at the root, 1 at the tip
    name: str
    mesh: StationMesh
    file: Path  # of its section
    results: SectionResults | None  # None: it has failed


def analysed(sections: Path, places: dict[str, float], meshes: list[StationMesh]) -> list[Station]:
    """Return the stations with the results of the last call of the section command.

    Files of earlier calls do not count: a station that has failed now has none.

    Parameters
    ----------
    sections : folder of the section files and their summary.json
    places : r by name of the station
    """
    summary = json.loads((sections / "summary.json").read_text(encoding="utf-8"))
    found = []
    for (name, r), mesh in zip(places.items(), meshes, strict=True):
        file = sections / name / f"{name}.vtkhdf"
        failed = summary[name]["status"] == "failed"
        found.append(Station(r, name, mesh, file, None if failed else read_results(file)))
    return found


def complete(stations: Sequence[Station]) -> list[Station]:
    """Return the stations that could be analysed."""
    return [station for station in stations if station.results is not None]


def station_csv(blade: Blade, stations: list[Station]) -> str:
    """Return the table of all complete stations."""
    head = ["r", "z_m", "chord_m", "twist_deg", "mass_kg_m", "removed"]
    head += [f"{letter}{i + 1}{j + 1}" for letter in "KM" for i, j in UPPER]
    stream = io.StringIO(newline="")
    writer = csv.writer(stream)
    writer.writerow(head)
    for station in stations:
        r, one = station.r, station.results
        if one is None:
            continue
        row = [r, blade.length.at(r), blade.chord.at(r), blade.twist.at(r), one.M[0, 0]]
        row += [station.mesh.removed, *(K[i, j] for K in (one.K, one.M) for i, j in UPPER)]
        writer.writerow([repr(float(value)) for value in row])
    return stream.getvalue()


def station_text(blade: Blade, stations: list[Station]) -> str:
    """Return what the screen shows of the stations."""
    lines = [
        f"{'r':>7}  {'z':>7}  {'chord':>6}  {'mass':>7}  {'EA':>10}  {'EI flap':>10}  "
        f"{'EI edge':>10}  {'GJ':>10}",
        f"{'[-]':>7}  {'[m]':>7}  {'[m]':>6}  {'[kg/m]':>7}  {'[N]':>10}  {'[N m2]':>10}  "
        f"{'[N m2]':>10}  {'[N m2]':>10}",
    ]
    for station in stations:
        if station.results is None:
            lines.append(f"{station.r:7.4f}  failed")
            continue
        K, M = station.results.K, station.results.M
        values = "  ".join(f"{K[i, i]:10.3e}" for i in (0, 4, 5, 3))
        z, chord = blade.length.at(station.r), blade.chord.at(station.r)
        lines.append(f"{station.r:7.4f}  {z:7.3f}  {chord:6.3f}  {M[0, 0]:7.2f}  {values}")
    return "\n".join(lines)
