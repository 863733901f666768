"""The commands `plymotion import` and `export`: bodies from and to other codes."""

import argparse
import sys
from pathlib import Path

from ...errors import InputError
from ...extras.exchange import export_body, import_body
from ...inputs.case.load import load_case
from ...studies.cases import build_folder, chosen_run
from ...workers.packages import prepared


def run_import(options: argparse.Namespace) -> int:
    """Run `plymotion import`; returns the exit code."""
    return _told(*import_body(options.file, options.out, options.source, quiet=options.quiet))


def run_export(options: argparse.Namespace) -> int:
    """Run `plymotion export`; returns the exit code."""
    if options.target == "fmu":
        return export_fmu(options)
    for name in ("run", "inputs", "coarse", "packages"):
        if getattr(options, name):
            raise InputError(f"--{name}: expected with --to fmu only")
    return _told(*export_body(options.file, options.target, options.out))


def _told(code: int, text: str) -> int:
    if text:
        print(text, file=sys.stderr if code else sys.stdout)
    return code


def export_fmu(options: argparse.Namespace) -> int:
    """Write a run of a case as an FMU; return the exit code."""
    from ...extras.fmu.write import write_fmu  # the solver takes 0.2 s to import

    file: Path = options.file
    if file.suffix != ".toml":
        raise InputError(f"{file}: expected a case file, CASE.toml, with --to fmu")
    case = load_case(file, coarse=options.coarse, sweeps=())
    run = chosen_run(case, options.run, only=True)
    folder = build_folder(file, coarse=options.coarse)
    run_file = prepared(case, folder, f"runs/{run}.json", options.packages)
    out: Path = options.out or folder / f"{run}.fmu"
    stepper = write_fmu(run_file, out, options.inputs)
    for name in stepper.left_out:
        print(f"signals.{name}: no output: it is known at the end of a run only")
    print(f"{out}: {len(stepper.inputs)} inputs, {len(stepper.outputs)} outputs")
    return 0
