"""The command `plymotion solid`: numbers and modal packages of parts from CAD."""

import argparse
from typing import Any, cast

from ...errors import InputError
from ...inputs.solid_specification import solid_spec
from ...report.solid import solid_table, solid_text
from ...workers.described import Made, entries_of
from .described import each, file_lines, run_described


def run_solid(options: argparse.Namespace) -> int:
    """Make and show the requested results; returns the exit code."""
    if options.size is not None and not options.size > 0.0:
        raise InputError(f"--size {options.size:g}: expected a length above 0")

    def text_of(one: Made) -> str:
        return f"{solid_text(solid_table(one.file))}\n{file_lines(one, [])}"

    return run_described(
        "solid",
        entries_of(options.files),
        options,
        ["--force"] if options.force else [],
        spec_of=lambda entry: cast(
            dict[str, Any], solid_spec(entry.file, options.material, options.size)
        ),
        show=each(lambda one: solid_table(one.file), text_of, options),
    )
