"""`plymotion blade`: meshes, sections and the table of all stations."""

import argparse
import sys
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...inputs.case.file import CASE_FILE
from ...package.common.replaceable import refuse_foreign
from ...package.common.temporary import write_text
from ..described.screen import USER_ERROR
from ..section.command import run_section
from ..section.options import add_section_command
from .body import body_csv
from .case import write_blade_case
from .export import write_for
from .spin import spin_blade
from .station import write_station
from .stations import analysed, complete, station_csv, station_text
from .windio import Blade, read_blade

REMOVED = 0.02  # share of the layers' area without room, above which a warning says so


def run_blade(options: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    blade = read_blade(options.file)
    for words in blade.left_out:
        print(f"warning [not-modelled] {blade.file}: {words}", file=sys.stderr)
    places = _stations(options, blade)
    out = options.out or Path("build") / "blades" / options.file.stem
    names = [f"r{round(1e4 * r):05d}" for r in places]
    if len(set(names)) < len(names):
        raise InputError("blade: stations closer than 1e-4 of the span")
    for written in ("blade.csv", "beam.csv", CASE_FILE):
        refuse_foreign(out / written)  # before the work
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
    if code not in (0, USER_ERROR):
        return code
    stations = analysed(out / "sections", dict(zip(names, places, strict=True)), meshes)
    write_text(out / "blade.csv", station_csv(blade, stations))
    write_text(out / "beam.csv", body_csv(blade, stations))
    print(station_text(blade, stations))
    count = len(complete(stations))
    print(f"{out}/blade.csv, beam.csv: {count} stations")
    for file in write_for(options.to, blade, stations, out) if options.to else ():
        print(file)
    if count > 1:
        case = write_blade_case(blade, stations, out)
        print(f"{case}: the blade on its hub; plymotion modes {case} --at spin=0:1:0.1")
    if options.spin:
        spin_blade(options.spin, blade, stations, out / CASE_FILE, quiet=options.quiet)
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
