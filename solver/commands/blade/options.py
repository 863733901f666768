"""Arguments of the command `plymotion blade`."""

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..arguments import numbers, whole_number
from ..modes.place import at_of
from ..section.codes import OF_BLADES

DESCRIPTION = """\
Cross-sections of a rotor blade: stiffness and mass matrices of its stations from a windIO 2 file.
The shell is meshed layer by layer to the thickness of the file, with its reinforcements, sandwich
panels, spar caps and webs.
"""
EPILOG = """\
Writes in DIR:
  stations/  a mesh and a section description of each station (docs/section-description.md)
  sections/  a section file of each station (.vtkhdf), and summary.csv
  blade.csv  span, chord, twist, 6x6 stiffness and mass of each station
  beam.csv   the blade as a body of a case: kind = "beam", table = "beam.csv"
  case.toml  this body on the turning hub of the file: plymotion modes DIR/case.toml --at spin=...
  blade_*    with --to: stiffness, mass and geometry for another code
  with --spin: frequencies.csv (at rest, with estimated errors), campbell.csv, .json and .png

Axes of a section: x2 from the reference axis to the leading edge along the chord, x3 to the suction
side, x1 to the tip. The matrices are about the reference axis, without twist. Stations that are up
to date are not analysed again, so an interrupted command continues where it stopped.

exit code: 0 done; 2 wrong input, or a station that cannot be analysed (the others are); 130
interrupted, complete files are kept.

example:
  plymotion blade IEA-15-240-RWT.yaml --stations 50 --jobs 2 --to beamdyn --spin 0:0.8:0.1 -o blade
"""


def add_blade_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `blade` to the subcommands of an argument parser; `run` executes it."""
    parser = commands.add_parser(
        "blade",
        help="cross-sections of a rotor blade from a windIO file",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="turbine file of windIO 2 (.yaml)")
    parser.add_argument(
        "--stations",
        type=partial(whole_number, least=2),
        metavar="N",
        help="equal distances from root to tip (default: the grid of the file's chord)",
    )
    parser.add_argument(
        "--at", type=_places, metavar="R,R,...", help="these stations, 0 at the root, 1 at the tip"
    )
    parser.add_argument(
        "--out", "-o", type=Path, metavar="DIR", help="folder (default build/blades/NAME)"
    )
    parser.add_argument(
        "--to", choices=OF_BLADES, metavar="CODE", help="also files for beamdyn or hawc2"
    )
    parser.add_argument(
        "--spin",
        type=_speeds,
        metavar="FIRST:LAST:STEP",
        help="also frequencies over the speed of the rotor [rad/s], or rpm: 0:12:1rpm",
    )
    parser.add_argument(
        "--jobs", type=whole_number, default=1, metavar="N", help="stations at a time (default 1)"
    )
    parser.add_argument("--no-estimate", action="store_true", help="skip the error estimate")
    parser.add_argument(
        "--check", action="store_true", help="write meshes and descriptions of the stations only"
    )
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.set_defaults(command=run)


def _speeds(text: str) -> str:
    """The text as it is, if `plymotion modes --at spin=` can read it."""
    try:
        at_of(f"spin={text}")
    except InputError as error:
        words = str(error).rpartition("; ")[0] or str(error)
        raise argparse.ArgumentTypeError(words.removeprefix("--at spin=")) from error
    return text


def _places(text: str) -> list[float]:
    found = numbers(text)
    if not found or not all(0.0 <= r <= 1.0 for r in found) or found != sorted(set(found)):
        raise argparse.ArgumentTypeError(f"{text!r}: expected rising numbers from 0 to 1")
    return found
