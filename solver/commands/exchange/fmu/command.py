"""`plymotion export CASE.toml --to fmu`: check the case, build its bodies, write the FMU."""

import argparse
from pathlib import Path

from ....errors import InputError
from ....inputs.case import load_case
from ....inputs.case.specs import write_case
from ...cases.chosen import build_folder, chosen_run
from ...cases.packages import build_needed
from .write import write_fmu


def export_fmu(options: argparse.Namespace) -> int:
    """Write a run of a case as an FMU; return the exit code."""
    file: Path = options.file
    if file.suffix != ".toml":
        raise InputError(f"{file}: expected a case file, CASE.toml, with --to fmu")
    case = load_case(file, coarse=options.coarse, sweeps=())
    run = chosen_run(case, options.run, only=True)
    folder = build_folder(file, coarse=options.coarse)
    write_case(case, folder, options.packages)
    run_file = folder / "runs" / f"{run}.json"
    if options.packages is None:
        build_needed([run_file])
    out: Path = options.out or folder / f"{run}.fmu"
    stepper = write_fmu(run_file, out, options.inputs)
    for name in stepper.left_out:
        print(f"signals.{name}: no output: it is known at the end of a run only")
    print(f"{out}: {len(stepper.inputs)} inputs, {len(stepper.outputs)} outputs")
    return 0
