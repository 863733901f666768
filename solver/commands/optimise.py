"""The command `plymotion optimise`: the best design of a study."""

import argparse
import sys
from pathlib import Path

from ..errors import InputError, few, nearest
from ..inputs.case.record import case_file
from ..inputs.common.text_file import read_toml
from ..report.design.page import PAGE
from ..report.table import json_text
from ..studies.cases import build_folder, folder_lock
from ..studies.design.design_text import outcome_lines
from ..studies.design.problem import FEASIBLE
from ..studies.design.study import optimise
from ..studies.design.trials import StudySpec
from ..studies.exit_codes import INCOMPLETE
from ..system.interrupts import INTERRUPTED
from ..workers.executors import executor_of


def run_optimise(options: argparse.Namespace) -> int:
    """Compute a study; return the exit code."""
    file = case_file(options.case)
    table = read_toml(file, "case file")
    design = table.get("design")
    studies = list(design.get("studies", {})) if isinstance(design, dict) else []
    name: str = options.study or (studies[0] if len(studies) == 1 else "")
    if name not in studies:
        if options.study:
            raise InputError(f"--study {name}: {file} has no such study{nearest(name, studies)}")
        known = f"--study: expected one of {few(studies)}" if studies else ""
        raise InputError(known or f"{file}: expected [design.studies.NAME] (docs/design.md)")
    folder: Path = options.out or build_folder(file, coarse=options.coarse)
    given = StudySpec(table, file, options.coarse, name, folder / "studies" / name)
    with folder_lock(folder):
        try:
            outcome = optimise(
                given, lambda: executor_of(options), fresh=options.fresh, show=not options.quiet
            )
        except KeyboardInterrupt:
            message = (
                "interrupted: the same command continues from the designs computed so far, if any"
            )
            print(f"{name}: {message}", file=sys.stderr)
            return INTERRUPTED
    if options.json:
        print(json_text(outcome))
    else:
        print("\n".join([*outcome_lines(outcome, given.folder), str(given.folder / PAGE)]))
    refused = outcome.get("verified", {}).get("why")
    return INCOMPLETE if refused or outcome["optimum"]["violation"] > FEASIBLE else 0
