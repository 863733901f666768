"""`plymotion blade`: meshes, sections and the table of all stations."""

import argparse
import json
import sys
from collections.abc import Sequence

from ...errors import InputError
from ...extras.blade.analysis import TABLE, Meshed, collected, folder_of, read_and_mesh, write_whole
from ...extras.blade.stations import (
    COUNT,
    Station,
    complete,
    error_csv,
    error_text,
    frequencies_at_rest,
    station_text,
)
from ...extras.blade.turbine import ROTOR_CASE
from ...inputs.case.record import CASE_FILE
from ...package.common.files import write_text
from ...studies.exit_codes import DEFECT, report, worst
from ...studies.generator_law import take_bent_blades
from ...workers.launch import kept_preprocessors
from ..body_arguments import add_section
from ..case_arguments import add_modes
from ..modes import run_modes
from .description_command import USER_ERROR
from .section import run_section

FREQUENCIES = "frequencies.csv"


@kept_preprocessors()  # for the sections, the frequencies at rest and those over speed
def run_blade(options: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    out = options.out or folder_of(options.file)
    for file in options.controller or ():
        if not (options.rotor and file.is_file()):
            why = "no such file" if options.rotor else "expected --rotor"
            raise InputError(f"blade: --controller {file}: {why}")
    codes: list[int] = []

    def failed(name: str, r: float, error: Exception) -> None:
        wrong = isinstance(error, InputError)
        codes.append(USER_ERROR if wrong else DEFECT)
        place = f"{options.file}: station r = {r:g}"
        print(f"error: {error if wrong else f'{place}: {report(error)}'}", file=sys.stderr)

    places = {"count": options.stations, "at": options.at or ()}
    meshed = read_and_mesh(options.file, out, **places, rotor=options.rotor, failed=failed)
    if options.check or not meshed.meshes:
        print(f"{out}/stations: {len(meshed.meshes)} stations")
        return worst(codes)
    code = run_section(_section_options(options, meshed))
    if code not in (0, USER_ERROR):
        return code
    summary = json.loads((meshed.sections / "summary.json").read_text(encoding="utf-8"))
    lost = {name for name in meshed.meshes if summary[name]["status"] == "failed"}
    stations = collected(meshed, lost)
    print(station_text(meshed.blade, stations))
    print(f"{out}/{TABLE}: {len(complete(stations))} stations")
    try:
        control = options.controller or ()
        files = write_whole(meshed, stations, options.to, rotor=options.rotor, controller=control)
    except InputError as error:
        if len(complete(stations)) == len(meshed.places):
            raise
        absent = ["beam.csv", CASE_FILE, *([f"blade_{options.to}*"] if options.to else [])]
        absent += [FREQUENCIES, "campbell.*"] if options.spin else []
        print(f"error: {error}; not written: {', '.join(absent)}", file=sys.stderr)
        return worst([*codes, code, USER_ERROR])
    for file in files:
        if file.name == ROTOR_CASE and not control:
            try:
                take_bent_blades(file)
            except InputError as error:
                print(f"{file}: best = torque of rigid blades over speed squared: {error}")
        hint = f": the blade on its hub; plymotion modes {file} --at spin=0:1:0.1"
        print(f"{file}{hint if file.name == CASE_FILE else ''}")
    if options.spin:
        _spin(options, meshed, stations)
    return code


def _spin(options: argparse.Namespace, meshed: Meshed, stations: Sequence[Station]) -> None:
    """Print and write the frequencies at rest with their errors, and those over speed."""
    if len(complete(stations)) < 2:
        raise InputError(f"blade: --spin {options.spin}: expected two complete stations or more")
    out = meshed.folder
    frequencies, errors = frequencies_at_rest(meshed.blade, stations)
    write_text(out / FREQUENCIES, error_csv(frequencies, errors))
    print(f"\n{error_text(frequencies, errors)}\n{out / FREQUENCIES}\n")
    parser = argparse.ArgumentParser()
    add_modes(parser.add_subparsers())
    words = ["modes", str(out / CASE_FILE), "--at", f"spin={options.spin}", "--count", str(COUNT)]
    words += ["--out", str(out), *(["--quiet"] if options.quiet else [])]
    run_modes(parser.parse_args(words))


def _section_options(options: argparse.Namespace, meshed: Meshed) -> argparse.Namespace:
    """The options that `plymotion section` gets."""
    parser = argparse.ArgumentParser()
    add_section(parser.add_subparsers())
    listed = meshed.folder / "stations" / "stations.txt"
    write_text(listed, "".join(f"{file.name}\n" for file in meshed.descriptions))
    words = ["section", "--batch", str(listed), "--out", str(meshed.sections)]
    words += ["--jobs", str(options.jobs)]
    words += ["--no-estimate"] if options.no_estimate else []
    words += ["--quiet"] if options.quiet else []
    return parser.parse_args(words)
