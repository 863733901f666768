"""Start the exchange with other codes, which is a part of the preprocessor, in this Python.

The solver does not import the preprocessor. It starts it as a process, as it does with FEniCSx; the
two exchange files only. This part of the preprocessor needs no FEniCSx, so the Python is the same.
"""

import argparse
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from ...errors import InputError
from ...extras.measured_modes import experimental_package, load_measurement, write_measured
from ...inputs.case import load_case
from ...inputs.case.reading.specs import write_case
from ...interrupts import INTERRUPTED
from ...studies.cases import build_folder, chosen_run
from ...studies.exit_codes import DEFECT
from ...workers.launch import environment, importable
from ...workers.packages import build_needed

TABLES = 4  # exit code of the exchange: the source has modes only, and their tables are written


def run_import(options: argparse.Namespace) -> int:
    """Run `plymotion import`; returns the exit code."""
    words = ["import", str(options.file), "--out", str(options.out)]
    words += ["--from", options.source] if options.source else []
    words += ["--quiet"] if options.quiet else []
    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder:
        code = exchange([*words, "--tables", folder])
        if code != TABLES:
            return code
        return _from_modes(Path(folder) / "measured.toml", options)


def _from_modes(tables: Path, options: argparse.Namespace) -> int:
    """Make the package of a source that has modes only, as `plymotion experimental` does."""
    package = experimental_package(load_measurement(tables))
    package.provenance["command"] = "plymotion import"
    package.provenance["import"] = options.file.read_text(encoding="utf-8")
    print(write_measured(options.out, package, options.file))
    return 0


def run_export(options: argparse.Namespace) -> int:
    """Run `plymotion export`; returns the exit code."""
    if options.target == "fmu":
        return export_fmu(options)
    for name in ("run", "inputs", "coarse", "packages"):
        if getattr(options, name):
            raise InputError(f"--{name}: expected with --to fmu only")
    words = ["export", str(options.file), "--to", options.target]
    return exchange([*words, *(["--out", str(options.out)] if options.out else [])])


def export_fmu(options: argparse.Namespace) -> int:
    """Write a run of a case as an FMU; return the exit code."""
    from ...extras.fmu.write import write_fmu  # the solver takes 0.2 s to import

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


def exchange(words: Sequence[str]) -> int:
    """Run `python -m plymotion.preprocess.exchange`; its output is that of this process."""
    with importable() as folder:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "plymotion.preprocess.exchange", *words],
            env=environment(folder),
        )
        try:
            code = process.wait()
        except KeyboardInterrupt:  # the terminal has interrupted both
            process.wait()
            return INTERRUPTED
    if code < 0:
        how = signal.strsignal(-code) or f"signal {-code}"
        print(f"error: {words[0]} of {words[1]}: the process was ended: {how}", file=sys.stderr)
        return DEFECT
    return code
