"""Arguments of the commands that work on cases, runs and sweeps."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from .arguments import (
    add,
    add_case_options,
    add_doubtful,
    add_executor,
    add_no_scripts,
    add_packages,
    add_report_figures,
    add_vector_figures,
    command,
    expecting,
    flag,
    numbers,
    shard,
    whole_number,
)

# Starter cases: the folders of starters/, and what each shows.
STARTERS = {
    "arm": "a driven laminated link with a payload",
    "robot-arm": "two laminated tubes with two drives, torques and ply strength",
    "panel": "a laminated plate (shell) on a turning hub",
    "bracket": "a part from CAD (STEP) that turns a payload",
    "pendulum": "a laminated bar on a hinge, set swinging",
    "blade": "a rotating composite blade, stiffened by its spin",
    "shaft": "a composite shaft in two bearings, run up through its critical speed",
}


NEW = "starters:\n" + "\n".join(f"  {name:10} {text}" for name, text in STARTERS.items())


_vector = expecting(numbers, lambda v: len(v) == 3 and any(v), "three numbers X,Y,Z, not all zero")


@command("new", "setup:run_new", NEW)
def add_new(parser: Any) -> None:
    """Write a starter case, which runs as it is."""
    parser.add_argument("starter", metavar=f"{{{','.join(STARTERS)}}}", help="see below")
    text = "new folder of the case (default: named like the starter)"
    parser.add_argument("folder", type=Path, nargs="?", metavar="DIR", help=text)


@command("check", "case:run_check")
def add_check(parser: Any) -> None:
    """Check a case file; with --out, write the input of the other commands."""
    parser.add_argument("case", type=Path, nargs="?", metavar="CASE", help="CASE.toml")
    add(parser, "--out", "DIR", "write case.json, bodies/, runs/, sweeps/ to DIR")
    add_case_options(parser)
    flag(parser, "reference", "print the list of all keys, docs/case-reference.md")


@command("run", "case:run_any")
def add_run(parser: Any) -> None:
    """Run a case file from check to report, or integrate run files.

    `plymotion CASE.toml` is `plymotion run CASE.toml`: it checks the case, builds its bodies in the
    Python with FEniCSx, integrates its runs and writes DIR/report.html. Files that are up to date
    are not made again.

    Several run files are integrated in one process, or in --jobs processes. A run that fails does
    not stop the others. Each run writes result.vtkhdf and summary.json.

    exit code: 0 all runs finished; 2 something is wrong with an input; 3 a run ended early, its
    results up to that time are kept, or a finding calls its results invalid, or it does not meet
    the accuracy of [fidelity]; 130, 143, 129 ended by Ctrl-C, TERM or HUP, results are kept.
    """
    text = "a case file, CASE.toml; or run files, build/CASE/runs/RUN.json"
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help=text)
    text = "of a case: its folder (default build/CASE); of one run file: folder of its results"
    parser.add_argument("--out", type=Path, metavar="DIR", help=text)
    text = "processes (default: 1 with run files, all cores with a case file)"
    parser.add_argument("--jobs", type=whole_number, metavar="N", help=text)
    text = "run the Python functions that a case names as controllers: only of cases you trust"
    flag(parser, "allow-python", text)
    add_doubtful(parser)
    flag(parser, "timing", "print the CPU time of each part")
    flag(parser, "quiet", "no progress bar")
    case = parser.add_argument_group("with a case file")
    add(case, "--run", "NAME", "only this run; may be given several times", str, action="append")
    text = "the members of this sweep, in place of the runs; may be given several times"
    case.add_argument("--sweep", action="append", metavar="NAME", help=text)
    add_case_options(case)
    flag(case, "force", "integrate runs that are up to date")
    flag(case, "no-report", "no report.html")
    add_report_figures(case)
    several = parser.add_argument_group("with run files")
    text = "each run gets a folder in DIR (default: build/CASE, above the run files)"
    several.add_argument("--out-dir", type=Path, metavar="DIR", help=text)
    flag(several, "update", "only runs whose inputs or solver have changed")


@command("report", "case:run_report")
def add_report(parser: Any) -> None:
    """Write report.html and the table of a case."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of a case, build/CASE")
    flag(parser, "live", "show runs under way, in DIR/live/report.html, until their command ends")
    add_report_figures(parser)
    flag(parser, "glb", "also write RUN/motion.glb, for Blender and slides")
    text = "also write RUN/motion.vtkhdf, for ParaView: surfaces with results in their cells"
    flag(parser, "vtk", text)


@command("modes", "modes:run_modes")
def add_modes(parser: Any) -> None:
    """Frequencies, damping and shapes about a state; Campbell diagram.

    Linearise a run about a state: frequencies, damping ratios, shapes.

    ---

    --at (default start):
      start              the start of the run, as the case gives it
      equilibrium        at rest under gravity, springs and loads; with solver.spin, turning
      t=0.5              the run at this time [s]
      spin=200           turning as a whole at a constant speed [rad/s]
      spin=20:400:20     from 20 to 400 rad/s by 20: a Campbell diagram
      spin=0:3000:100rpm the same in revolutions per minute

    The axis of a spin is that of --axis, of solver.spin in the case, or of the hinge to the ground.

    Writes modes.json (all numbers), modes.png (shapes), mode-NN.vtkhdf (one period of a mode for
    ParaView), linear.npz and linear.mat (A, B, C, D with names and units), with --response also
    response.csv and response.png. A range of speeds writes campbell.json, campbell.csv and
    campbell.png instead. Meaning and accuracy: docs/modes-about-a-state.md

    exit code: 0 done; 2 something is wrong with the input.

    examples:
      plymotion modes cases/double-pendulum/case.toml --at equilibrium
      plymotion modes cases/rotating-blade/case.toml --run stiffened --at spin=0:400:20 --axis 0,0,1
    """
    add(parser, "case", "FILE", "CASE.toml, or a run file, build/CASE/runs/RUN.json")
    parser.add_argument("--run", metavar="NAME", help="run of the case (default: the first)")
    parser.add_argument("--at", default="start", metavar="STATE", help="state, see below")
    text = "axis of the spin through the origin, global, such as 0,0,1 (default: see below)"
    parser.add_argument("--axis", type=_vector, metavar="X,Y,Z", help=text)
    text = "modes on the screen, and followed over speed (default 20)"
    parser.add_argument("--count", type=whole_number, default=20, metavar="N", help=text)
    count = partial(whole_number, least=0)
    add(parser, "--shapes", "N", "shapes drawn and animated (default 6; 0: none)", count, default=6)
    text = "lines 1P to NP of a Campbell diagram (default 4)"
    parser.add_argument("--harmonics", type=count, default=4, metavar="N", help=text)
    text = "axes of a Campbell diagram (default auto: fixed if all modes are whirls)"
    axes = ("auto", "turning", "fixed")
    parser.add_argument("--axes", choices=axes, default="auto", help=text)
    text = "transfer functions from forces and drives to signals between frequencies [Hz]"
    parser.add_argument("--response", metavar="LOW:HIGH", help=text)
    for name, what in (("input", "drive or load"), ("output", "signal")):
        text = f"{what} of --response (default: all); may be given several times"
        parser.add_argument(f"--{name}", action="append", metavar="NAME", help=text)
    text = "folder of the case (default build/CASE); results go to DIR/modes/RUN-STATE"
    parser.add_argument("--out", type=Path, metavar="DIR", help=text)
    add_case_options(parser)
    flag(parser, "json", "print modes.json, not the table")
    flag(parser, "quiet", "no progress")


@command("sensitivities", "sensitivities:run_sensitivities")
def add_sensitivities(parser: Any) -> None:
    """Differentiate the signals of a run by numbers of its case.

    The derivatives of the motion are integrated beside the run, whose integrator must be "radau",
    for all numbers together. Keys are those of sweeps, such as forces.spring.stiffness or
    gravity.2, and names of [design.parameters], such as ply angles.

    Writes result.vtkhdf (the run, with /sensitivities/SIGNAL/KEY at all output times) and
    summary.json, and prints which number has the most effect. Method and limits:
    docs/sensitivities.md

    With --objective the derivatives are those of one number, by the adjoint of the run: for many
    parameters. summary.json has them under `objective`.

    exit code: 0 done; 2 something is wrong with the input, or has no derivative; 130 interrupted.

    example:
      plymotion sensitivities case.toml --run base --of masses.tip.mass gravity.2
    """
    parser.add_argument("case", type=Path, metavar="CASE", help="CASE.toml")
    parser.add_argument("--run", metavar="NAME", help="run of the case (default: the first)")
    add(parser, "--of", "KEY", "keys (default: all [design.parameters])", str, nargs="+")
    text = 'one number in place of signals, as in studies: \'{ signal = "tip", of = "rms" }\''
    parser.add_argument("--objective", metavar="TABLE", help=text)
    text = "folder of the case (default build/CASE); results go to DIR/sensitivities/RUN"
    parser.add_argument("--out", type=Path, metavar="DIR", help=text)
    add_case_options(parser)
    flag(parser, "quiet", "no progress")


@command("plan", "plan:run_plan")
def add_plan(parser: Any) -> None:
    """Choose the model of a run by its accuracy.

    The case needs [fidelity] (docs/fidelity.md). Packages that are out of date are built. The plan
    is written to DIR/plans/RUN.toml, where `plymotion run` finds it. With --chart, an existing plan
    is used, and error against CPU time of the models is printed and drawn, from rigid bodies to all
    modes.

    exit code: 0 the request is met; 2 something is wrong with an input; 3 the request is not met.
    """
    parser.add_argument("case", type=Path, metavar="CASE", help="CASE.toml")
    parser.add_argument("--run", metavar="NAME", help="run of the case (default: the first)")
    add(parser, "--out", "DIR", "folder of the case (default: build/CASE)")
    add_packages(parser)
    add_no_scripts(parser)
    flag(parser, "no-check", "indicators only: no run of model and check")
    flag(parser, "json", "print the answer as JSON")
    flag(parser, "chart", "draw error against CPU time of the models")
    add(parser, "--figure", "PNG", "the chart (default: DIR/plans/RUN.png)")


@command("packages", "bodies.packages:run_packages")
def add_packages_command(parser: Any) -> None:
    """Build the modal packages of runs and sweeps.

    Builds the packages that run files (build/<case>/runs/<run>.json) and sweep files
    (build/<case>/sweeps/<name>.json) name, each once, into the folders where runs and sweeps look
    for them. Packages that are up to date are not built again.

    exit code: 0 all packages are up to date; 2 wrong input; 3 some bodies could not be built, the
    others were; 130 interrupted, complete packages are kept.
    """
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="run or sweep file")
    add_executor(parser, "bodies")
    add_no_scripts(parser)
    flag(parser, "quiet", "print warnings and errors only")


@command("sweep", "sweep:run_sweep")
def add_sweep(parser: Any) -> None:
    """Integrate the members of a sweep.

    Writes DIR/sweep.h5 (docs/sweeps.md), the table DIR/sweep.csv and a figure for each signal.
    Members that the same solver has computed before, with the same values and packages, are not
    computed again: an interrupted sweep, or one with additional values, continues.

    --merge computes nothing: it joins DIR/sweep-k-of-N.h5, the files of --shard k/N, which stay,
    and an earlier DIR/sweep.h5.

    exit code: 0 all members finished; 2 something is wrong with the input; 3 some members stopped
    or failed, the table has their messages and the others are complete, or members are missing in
    the files that are merged; 130 interrupted, finished members are kept.
    """
    add(parser, "sweep", "SWEEP", "build/CASE/sweeps/SWEEP.json, written by check")
    add(parser, "--out", "DIR", "folder (default build/CASE/sweeps/SWEEP)")
    add_doubtful(parser)
    text = "only the k-th of N shares of the members, into DIR/sweep-k-of-N.h5, see --merge"
    parser.add_argument("--shard", type=shard, metavar="k/N", help=text)
    add_executor(parser, "members")
    again = parser.add_mutually_exclusive_group()
    flag(again, "fresh", "compute all members again")
    flag(again, "restart", "compute missing members only (the default)")
    flag(parser, "merge", "join the files of all shares")
    flag(parser, "csv", "print the table")
    text, action = "draw a figure for each signal (default: yes)", argparse.BooleanOptionalAction
    parser.add_argument("--figures", action=action, default=True, help=text)
    add_vector_figures(parser)
    flag(parser, "quiet", "no progress bar")


@command("optimise", "optimise:run_optimise")
def add_optimise(parser: Any) -> None:
    """Search for the best design of a study.

    The case needs [design.parameters] and [design.studies.NAME] (docs/design.md). Every design has
    packages of its own, built in the Python with FEniCSx, and is run. Writes
    DIR/studies/STUDY/design.json (the best design, before and after, all starts), study.jsonl (what
    was computed of each design) and optimum.toml (the best design as a variant of the case).
    The same command goes on where an earlier one was interrupted.

    exit code: 0 done; 2 something is wrong with the input; 3 the best design breaks a limit or
    could not be verified; 130, 143, 129 interrupted, finished designs are kept.
    """
    parser.add_argument("case", type=Path, metavar="CASE", help="CASE.toml")
    parser.add_argument("--study", metavar="NAME", help="study of the case (default: the only one)")
    add(parser, "--out", "DIR", "folder of the case (default: build/CASE)")
    add_executor(parser, "starts")
    flag(parser, "coarse", "apply the [coarse] variant")
    flag(parser, "fresh", "compute all designs again")
    add_no_scripts(parser)
    flag(parser, "json", "print design.json, not the table")
    flag(parser, "quiet", "no progress bar")
