"""The command `plymotion sensitivities`."""

import argparse
from pathlib import Path

from ..inputs.case.load import checked_case
from ..inputs.case.record import case_file
from ..inputs.common.text_file import read_toml
from ..studies.cases import build_folder, chosen_run
from ..studies.sensitivities.work import (
    compute_sensitivities,
    sensitivity_table,
    write_sensitivities,
)


def run_sensitivities(options: argparse.Namespace) -> int:
    """Differentiate a run; return 0."""
    file = case_file(options.case)
    table = read_toml(file, "case file")
    run = chosen_run(checked_case(table, file, coarse=options.coarse, sweeps=()), options.run)
    build: Path = options.out or build_folder(file, coarse=options.coarse)
    result, summary = compute_sensitivities(
        table,
        file,
        run,
        options.of,
        build=build,
        packages=options.packages,
        coarse=options.coarse,
        progress=not options.quiet,
    )
    folder = build / "sensitivities" / run
    files = write_sensitivities(folder, result, summary)
    print(sensitivity_table(result))
    print(f"{folder}: {', '.join(files)}")
    return 0
