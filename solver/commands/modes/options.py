"""Arguments of the command `plymotion modes`."""

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from ..arguments import add_case_options, add_no_scripts, numbers, whole_number

EPILOG = """\
--at (default start):
  start              the start of the run, as the case gives it
  equilibrium        at rest under gravity, springs and loads; with solver.spin, turning
  t=0.5              the run at this time [s]
  spin=200           turning as a whole at a constant speed [rad/s]
  spin=20:400:20     from 20 to 400 rad/s by 20: a Campbell diagram
  spin=0:3000:100rpm the same in revolutions per minute

The axis of a spin is that of --axis, of solver.spin in the case, or of the hinge to the ground.

Writes modes.json (all numbers), modes.png (shapes), mode-NN.vtkhdf (one period of a mode
for ParaView), linear.npz and linear.mat (A, B, C, D with names and units), with --response also
response.csv and response.png. A range of speeds writes campbell.json, campbell.csv and campbell.png
instead. Meaning and accuracy: docs/modes-about-a-state.md

exit code: 0 done; 2 something is wrong with the input.

examples:
  plymotion modes cases/double-pendulum/case.toml --at equilibrium
  plymotion modes cases/rotating-blade/case.toml --run stiffened --at spin=0:400:20 --axis 0,0,1
"""


def add_modes_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `modes` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "modes",
        help="frequencies, damping and shapes about a state; Campbell diagram",
        description="Linearise a run about a state: frequencies, damping ratios, shapes.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "case",
        type=Path,
        metavar="FILE",
        help="CASE.toml, or a run file, build/CASE/runs/RUN.json",
    )
    parser.add_argument("--run", metavar="NAME", help="run of the case (default: the first)")
    parser.add_argument("--at", default="start", metavar="STATE", help="state, see below")
    parser.add_argument(
        "--axis",
        type=_vector,
        metavar="X,Y,Z",
        help="axis of the spin through the origin, global, such as 0,0,1 (default: see below)",
    )
    parser.add_argument(
        "--count",
        type=whole_number,
        default=20,
        metavar="N",
        help="modes on the screen, and followed over speed (default 20)",
    )
    parser.add_argument(
        "--shapes",
        type=partial(whole_number, least=0),
        default=6,
        metavar="N",
        help="shapes drawn and animated (default 6; 0: none)",
    )
    parser.add_argument(
        "--harmonics",
        type=partial(whole_number, least=0),
        default=4,
        metavar="N",
        help="lines 1P to NP of a Campbell diagram (default 4)",
    )
    parser.add_argument(
        "--axes",
        choices=("auto", "turning", "fixed"),
        default="auto",
        help="axes of a Campbell diagram (default auto: fixed if all modes are whirls)",
    )
    parser.add_argument(
        "--response",
        metavar="LOW:HIGH",
        help="transfer functions from forces and drives to signals between frequencies [Hz]",
    )
    parser.add_argument(
        "--input",
        action="append",
        metavar="NAME",
        help="drive or load of --response (default: all); may be given several times",
    )
    parser.add_argument(
        "--output",
        action="append",
        metavar="NAME",
        help="signal of --response (default: all); may be given several times",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the case (default build/CASE); results go to DIR/modes/RUN-STATE",
    )
    add_case_options(parser)
    add_no_scripts(parser)
    parser.add_argument("--json", action="store_true", help="print modes.json, not the table")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.set_defaults(command=run)


def _vector(text: str) -> list[float]:
    found = numbers(text)
    if len(found) != 3 or not any(found):
        raise argparse.ArgumentTypeError(f"{text!r}: expected three numbers X,Y,Z, not all zero")
    return found
