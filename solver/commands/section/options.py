"""Arguments of the command `plymotion section`."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...errors import did_you_mean
from ..arguments import number, numbers, shard
from ..described.options import add_command, add_out, add_shared
from ..executors.choice import add_executor
from .codes import CODES, TARGETS

FOLDER = Path("build") / "sections"

DESCRIPTION = """\
Stiffness, mass, centres and stresses of beam cross-sections. FILE is a description (TOML,
docs/section-description.md), an input file of VABS (.dat, .sg), a folder of BECAS input, or a
section file (.vtkhdf) to show again. It runs in the Python with FEniCSx:
$FENICSX_PYTHON, the one that `make fenicsx` found, python3 or /usr/bin/python3.
"""
EPILOG = """\
Writes DIR/<name>/<name>.vtkhdf, a section file with mesh, plies, warping and stress recovery that
ParaView opens, and figures beside it. Files made from the same description, options and sources
are not made again, so an interrupted batch continues where it stopped.

A batch (LIST) is a folder of descriptions, a pattern in quotes, a text file with one description
per line, or a study in TOML: `sections` to vary and [[sweep]] tables of a key and its values (or a
CSV file with a row of numbers for each). It writes DIR/summary.csv and .json.

K relates [F1 F2 F3 M1 M2 M3] to [extension, shear 2, shear 3, twist, bending 2, bending 3] at the
origin of the description; --order gives it in the order of other codes (docs/conventions.md).

exit code: 0 done; 2 wrong input, the other sections of a batch are made; 130 interrupted,
complete files are kept.
"""


def add_section_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `section` to the subcommands of an argument parser; `run` executes it."""
    texts = {"description": DESCRIPTION, "epilog": EPILOG}
    parser = add_command(commands, "section", run, help="analyse beam cross-sections", **texts)
    what = parser.add_argument_group("what to make")
    what.add_argument("files", nargs="*", type=Path, metavar="FILE", help="section description")
    what.add_argument("--batch", metavar="LIST", help="analyse many sections, see below")
    what.add_argument(
        "--shard", type=shard, metavar="k/N", help="only the k-th of N shares of LIST"
    )
    what.add_argument(
        "--accuracy",
        type=_accuracy,
        metavar="A",
        help="refine until the estimated error of K, scaled by sqrt(Kii Kjj), is below A",
    )
    what.add_argument("--no-estimate", action="store_true", help="skip the error estimate (faster)")
    what.add_argument(
        "--verify", action="store_true", help="compute K by a second method as well, and compare"
    )
    add_shared(what, "figures", help="draw figures (default: for FILE without --json)")
    add_shared(what, "force", "check")
    what.add_argument(
        "--to",
        choices=TARGETS,
        help="also write the input of another code: vabs and becas for each section, beamdyn and "
        "hawc2 for the stations of a blade",
    )
    what.add_argument(
        "--stations",
        type=_positions,
        metavar="R1,R2,...",
        help="with --to beamdyn or hawc2: position of each FILE along the blade [m]",
    )
    how = parser.add_argument_group("how and where")
    add_out(how, FOLDER)
    add_executor(how, "sections")
    add_shared(how, "quiet")
    shown = parser.add_argument_group("what to show")
    add_shared(shown, "json")
    shown.add_argument(
        "--order",
        type=_code,
        default="plymotion",
        metavar="CODE",
        help=f"order and signs of K and M: {', '.join(CODES)}",
    )
    shown.add_argument(
        "--loads",
        type=_loads,
        metavar="F1,F2,F3,M1,M2,M3",
        help="also the stresses and margins of every ply under these resultants [N, N m]; write "
        "--loads=-1,... if the first is negative",
    )
    shown.add_argument(
        "--corner-distance",
        type=_distance,
        metavar="D",
        help="with --loads: leave out points nearer than D [m] to a re-entrant corner, where "
        "stresses depend on the mesh",
    )


def _code(text: str) -> str:
    code = {"anba": "anba4"}.get(text, text)
    if code not in CODES:
        hint = did_you_mean(code, CODES)
        raise argparse.ArgumentTypeError(f"{text!r}: expected one of {', '.join(CODES)}{hint}")
    return code


def _accuracy(text: str) -> float:
    value = number(text)
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a number from 0 to 1, such as 1e-3")
    return value


def _positions(text: str) -> list[float]:
    values = numbers(text)
    if not values:
        raise argparse.ArgumentTypeError(f"{text!r}: expected numbers with commas [m]")
    return values


def _distance(text: str) -> float:
    value = number(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a length above 0 [m]")
    return value


def _loads(text: str) -> list[float]:
    values = numbers(text)
    if len(values) != 6:
        raise argparse.ArgumentTypeError(
            f"{text!r}: expected six numbers with commas, F1,F2,F3,M1,M2,M3 [N, N m]"
        )
    return values
