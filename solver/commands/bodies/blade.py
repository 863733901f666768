"""`plymotion blade`: meshes, sections and the table of all stations."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...extras.blade.layers import StationMesh
from ...extras.blade.station import write_station
from ...extras.blade.stations import (
    COUNT,
    Station,
    analysed,
    body_csv,
    complete,
    error_csv,
    error_text,
    frequencies_at_rest,
    station_csv,
    station_text,
    write_blade_case,
    write_for,
)
from ...extras.blade.windio import Blade, differences, read_blade
from ...inputs.case.file import CASE_FILE
from ...package.common.replaceable import refuse_foreign
from ...package.common.temporary import write_text
from ...studies.exit_codes import DEFECT, report, worst
from ..body_arguments import add_section
from ..case_arguments import add_modes
from ..cases.modes import run_modes
from .described import USER_ERROR
from .section import run_section

# Frequencies of a blade over the speed of its rotor.

FREQUENCIES = "frequencies.csv"


def spin_blade(
    speeds: str, blade: Blade, stations: Sequence[Station], case: Path, *, quiet: bool
) -> None:
    """Print and write the frequencies at rest with their errors, and those over speed.

    Parameters
    ----------
    speeds : as `plymotion modes --at spin=` has them
    case : the case of the blade; the files are written beside it

    Raises
    ------
    InputError : fewer than two complete stations; what `plymotion modes` finds.
    """
    if len(complete(stations)) < 2:
        raise InputError(f"blade: --spin {speeds}: expected two complete stations or more")
    out = case.parent
    frequencies, errors = frequencies_at_rest(blade, stations, quiet=True)
    write_text(out / FREQUENCIES, error_csv(frequencies, errors))
    print(f"\n{error_text(frequencies, errors)}\n{out / FREQUENCIES}\n")
    parser = argparse.ArgumentParser()
    add_modes(parser.add_subparsers())
    words = ["modes", str(case), "--at", f"spin={speeds}", "--count", str(COUNT)]
    words += ["--out", str(out), *(["--quiet"] if quiet else [])]
    run_modes(parser.parse_args(words))


# `plymotion blade`: meshes, sections and the table of all stations.

REMOVED = 0.02  # share of the layers' area without room, above which a warning says so


def run_blade(options: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    blade = read_blade(options.file)
    for words in blade.left_out:
        _warning("not-modelled", f"{blade.file}: {words}")
    for words in blade.doubtful:
        _warning("unlike-a-blade", f"{blade.file}: {words}")
    for words in blade.differences:
        _warning("rule-differs", f"{blade.file}: {words}")
    places = _stations(options, blade)
    out = options.out or Path("build") / "blades" / options.file.stem
    names = {f"r{round(1e4 * r):05d}": r for r in places}
    if len(names) < len(places):
        raise InputError("blade: stations closer than 1e-4 of the span")
    for written in ("blade.csv", "beam.csv", CASE_FILE):
        refuse_foreign(out / written)  # before the work
    meshes, codes = _meshes(blade, names, out / "stations")
    if options.check or not meshes:
        print(f"{out}/stations: {len(meshes)} stations")
        return worst(codes)
    code = run_section(_section_options(options, out, list(meshes)))
    if code not in (0, USER_ERROR):
        return code
    good = {name: names[name] for name in meshes}
    stations = analysed(out / "sections", good, list(meshes.values()))
    for station in complete(stations):
        _compare(blade, station)
    write_text(out / "blade.csv", station_csv(blade, stations))
    print(station_text(blade, stations))
    done = complete(stations)
    print(f"{out}/blade.csv: {len(done)} stations")
    if len(done) < len(names):
        found = {station.name for station in done}
        lost = ", ".join(f"{r:g}" for name, r in names.items() if name not in found)
        print(
            f"error: blade: r = {lost}: without these stations the blade is another one; not "
            f"written: {', '.join(_of_the_blade(options))}",
            file=sys.stderr,
        )
        return worst([*codes, code, USER_ERROR])
    write_text(out / "beam.csv", body_csv(blade, stations))
    print(out / "beam.csv")
    for file in write_for(options.to, blade, stations, out) if options.to else ():
        print(file)
    if len(done) > 1:
        case = write_blade_case(blade, stations, out)
        print(f"{case}: the blade on its hub; plymotion modes {case} --at spin=0:1:0.1")
    if options.spin:
        spin_blade(options.spin, blade, stations, out / CASE_FILE, quiet=options.quiet)
    return code


def _warning(code: str, words: str) -> None:
    print(f"warning [{code}] {words}", file=sys.stderr)


def _of_the_blade(options: argparse.Namespace) -> list[str]:
    """Files of the whole blade that the command is asked for."""
    spin = ["frequencies.csv", "campbell.*"] if options.spin else []
    return ["beam.csv", CASE_FILE, *([f"blade_{options.to}*"] if options.to else []), *spin]


def _meshes(
    blade: Blade, names: Mapping[str, float], folder: Path
) -> tuple[dict[str, StationMesh], list[int]]:
    """The meshes of the stations by name, and the exit codes of those that have failed."""
    meshes, codes = {}, []
    for name, r in names.items():
        try:
            meshes[name] = write_station(blade, r, name, folder)
        except InputError as error:
            print(f"error: {error}", file=sys.stderr)
            codes.append(USER_ERROR)
            continue
        except (ValueError, ArithmeticError, LookupError) as error:  # the others can be right
            print(f"error: {blade.file}: station r = {r:g}: {report(error)}", file=sys.stderr)
            codes.append(DEFECT)
            continue
        if meshes[name].removed > REMOVED:
            _warning(
                "no-room",
                f"station r = {r:g}: {meshes[name].removed:.1%} of the layers find no room "
                "between the two sides and are not there",
            )
    return meshes, codes


def _compare(blade: Blade, station: Station) -> None:
    """Say in which quantities a station differs from what the file has for it."""
    if blade.given is None or station.results is None:
        return
    if found := differences(blade.given, station.r, station.results):
        _warning(
            "differs-from-file", f"{blade.file}: station r = {station.r:g}: {'; '.join(found)}"
        )


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
    add_section(parser.add_subparsers())
    listed = out / "stations" / "stations.txt"
    write_text(listed, "".join(f"{name}.toml\n" for name in names))
    words = ["section", "--batch", str(listed), "--out", str(out / "sections")]
    words += ["--jobs", str(options.jobs)]
    words += ["--no-estimate"] if options.no_estimate else []
    words += ["--quiet"] if options.quiet else []
    return parser.parse_args(words)
