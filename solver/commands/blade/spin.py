"""Frequencies of a blade over the speed of its rotor."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from ...errors import InputError
from ...package.common.temporary import write_text
from ..case_arguments import add_modes
from ..modes.command import run_modes
from .errors import COUNT, error_csv, error_text, frequencies_at_rest
from .stations import Station, complete
from .windio import Blade

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
