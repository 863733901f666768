"""The command `plymotion plan`: the model of a run, chosen by its accuracy."""

import argparse
import json
from pathlib import Path

from ...errors import InputError
from ...fidelity.delivery.execution import answered
from ...fidelity.delivery.words import answer_text, entry
from ...inputs.case import load_case
from ...inputs.case.file import case_file
from ...inputs.case.specs import write_case
from ..cases.chosen import build_folder, chosen_run
from ..cases.packages import build_needed
from ..exit_codes import INCOMPLETE


def run_file_of(options: argparse.Namespace) -> Path:
    """Check a case, write its run files, build the packages, and return one run file.

    Raises
    ------
    InputError
        The case is wrong, has no such run, or its run has no [fidelity]; a package cannot be
        built.
    """
    file = case_file(options.case)
    case = load_case(file, sweeps=())
    run = chosen_run(case, options.run)
    if case.runs[run].fidelity is None:
        raise InputError(
            f"{file}: run {run} has no [fidelity]: expected a table with accuracy and "
            "signals (docs/fidelity.md)"
        )
    folder: Path = options.out or build_folder(file)
    write_case(case, folder, options.packages)
    run_file = folder / "runs" / f"{run}.json"
    if options.packages is None:
        build_needed([run_file])
    return run_file


def run_plan(options: argparse.Namespace) -> int:
    """Print the plan of a run; return the exit code."""
    answer = answered(run_file_of(options), again=True, check=not options.no_check)
    if options.json:
        print(json.dumps(entry(answer), indent=2))
    else:
        print(answer_text(answer))
    return INCOMPLETE if answer.verdict == "not met" else 0
