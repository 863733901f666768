"""`plymotion blade`: meshes, sections and the table of all stations."""

import argparse
import csv
import io
import sys
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...package.common.temporary import write_text
from ..section.command import run_section
from ..section.options import add_section_command
from ..section.results import SectionResults, read_results
from .mesh import StationMesh
from .station import write_station
from .windio import Blade, read_blade

REMOVED = 0.02  # share of the layers' area without room, above which a warning says so
UPPER = [(i, j) for i in range(6) for j in range(i, 6)]


def run_blade(options: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    blade = read_blade(options.file)
    places = _stations(options, blade)
    out = options.out or Path("build") / "blades" / options.file.stem
    names = [f"r{round(1e4 * r):05d}" for r in places]
    if len(set(names)) < len(names):
        raise InputError("blade: stations closer than 1e-4 of the span")
    meshes = []
    for name, r in zip(names, places, strict=True):
        meshes.append(write_station(blade, r, name, out / "stations"))
        if meshes[-1].removed > REMOVED:
            print(
                f"warning [no-room] station r = {r:g}: {meshes[-1].removed:.1%} of the layers find "
                "no room between the two sides and were made thinner",
                file=sys.stderr,
            )
    if options.check:
        print(f"{out}/stations: {len(names)} stations")
        return 0
    code = run_section(_section_options(options, out, names))
    found = {
        name: read_results(file)
        for name in names
        if (file := out / "sections" / name / f"{name}.vtkhdf").is_file()
    }
    write_text(out / "blade.csv", _csv(blade, places, names, meshes, found))
    print(_text(blade, places, names, found))
    print(f"{out}/blade.csv: {len(found)} stations")
    return code


def _stations(options: argparse.Namespace, blade: Blade) -> list[float]:
    if options.at and options.stations:
        raise InputError("blade: expected --stations or --at, not both")
    if options.at:
        return list(options.at)
    if options.stations:
        return [float(r) for r in np.linspace(0.0, 1.0, options.stations)]
    return [float(r) for r in np.unique(np.clip(blade.span, 0.0, 1.0))]


def _section_options(
    options: argparse.Namespace, out: Path, names: list[str]
) -> argparse.Namespace:
    """The options that `plymotion section` gets."""
    parser = argparse.ArgumentParser()
    add_section_command(parser.add_subparsers(), run_section)
    listed = out / "stations" / "stations.txt"
    write_text(listed, "".join(f"{name}.toml\n" for name in names))
    words = ["section", "--batch", str(listed), "--out", str(out / "sections")]
    words += ["--jobs", str(options.jobs)]
    words += ["--no-estimate"] if options.no_estimate else []
    words += ["--quiet"] if options.quiet else []
    return parser.parse_args(words)


def _csv(
    blade: Blade,
    places: list[float],
    names: list[str],
    meshes: list[StationMesh],
    found: dict[str, SectionResults],
) -> str:
    head = ["r", "z_m", "chord_m", "twist_deg", "mass_kg_m", "removed"]
    head += [f"{letter}{i + 1}{j + 1}" for letter in "KM" for i, j in UPPER]
    stream = io.StringIO(newline="")
    writer = csv.writer(stream)
    writer.writerow(head)
    for name, r, mesh in zip(names, places, meshes, strict=True):
        if name not in found:
            continue
        one = found[name]
        row = [r, blade.length.at(r), blade.chord.at(r), blade.twist.at(r), one.M[0, 0]]
        row += [mesh.removed, *(K[i, j] for K in (one.K, one.M) for i, j in UPPER)]
        writer.writerow([repr(float(value)) for value in row])
    return stream.getvalue()


def _text(
    blade: Blade, places: list[float], names: list[str], found: dict[str, SectionResults]
) -> str:
    lines = [
        f"{'r':>7}  {'z':>7}  {'chord':>6}  {'mass':>7}  {'EA':>10}  {'EI flap':>10}  "
        f"{'EI edge':>10}  {'GJ':>10}",
        f"{'[-]':>7}  {'[m]':>7}  {'[m]':>6}  {'[kg/m]':>7}  {'[N]':>10}  {'[N m2]':>10}  "
        f"{'[N m2]':>10}  {'[N m2]':>10}",
    ]
    for name, r in zip(names, places, strict=True):
        if name not in found:
            lines.append(f"{r:7.4f}  failed")
            continue
        K, M = found[name].K, found[name].M
        values = "  ".join(f"{K[i, i]:10.3e}" for i in (0, 4, 5, 3))
        z, chord = blade.length.at(r), blade.chord.at(r)
        lines.append(f"{r:7.4f}  {z:7.3f}  {chord:6.3f}  {M[0, 0]:7.2f}  {values}")
    return "\n".join(lines)
