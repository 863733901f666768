"""The command `plymotion sensitivities`."""

import argparse
import tomllib
from pathlib import Path

from ..errors import InputError
from ..inputs.case.load import checked_case
from ..inputs.case.record import case_file
from ..inputs.common.text_file import read_toml
from ..studies.cases import build_folder, chosen_run
from ..studies.design.gradient import Asked, compute_gradient, compute_sensitivities, gradient_table
from ..studies.sensitivities.case_sensitivities import sensitivity_table, write_sensitivities


def _objective(text: str) -> dict[str, object]:
    """Return the table of --objective, written as in a case file."""
    try:
        return tomllib.loads(f"objective = {text}")["objective"]
    except (tomllib.TOMLDecodeError, TypeError) as error:
        raise InputError(
            f"--objective {text}: {error}; expected a table, as in `minimise` of a study"
        ) from error


def run_sensitivities(options: argparse.Namespace) -> int:
    """Differentiate a run; return 0."""
    file = case_file(options.case)
    table = read_toml(file, "case file")
    run = chosen_run(checked_case(table, file, coarse=options.coarse, sweeps=()), options.run)
    build: Path = options.out or build_folder(file, coarse=options.coarse)
    asked = Asked(table, file, run, options.of or (), build, options.packages, options.coarse)
    if options.objective is None:
        result, summary = compute_sensitivities(asked, progress=not options.quiet)
    else:
        result, summary = compute_gradient(asked, _objective(options.objective))
    folder = build / "sensitivities" / run
    files = write_sensitivities(folder, result, summary)
    print(gradient_table(summary) if options.objective else sensitivity_table(result))
    print(f"{folder}: {', '.join(files)}")
    return 0
