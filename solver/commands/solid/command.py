"""The command `plymotion solid`: numbers and modal packages of parts from CAD."""

import argparse
from typing import Any, cast

from ...errors import InputError
from ...inputs.solid.expand import solid_spec
from ...package.body.io import read_package
from ..body_arguments import FOLDERS
from ..described.entries import entries_of
from ..described.make import Made, Request
from ..described.run import run_described
from ..described.screen import file_lines, show_each
from .show import solid_text


def run_solid(options: argparse.Namespace) -> int:
    """Make and show the requested results; returns the exit code."""
    if options.size is not None and not options.size > 0.0:
        raise InputError(f"--size {options.size:g}: expected a length above 0")

    def table_of(one: Made) -> dict[str, Any]:
        provenance = read_package(one.file).provenance
        found = provenance.get("solid")
        if not isinstance(found, dict) or "free_hz" not in found:
            raise InputError(
                f"{one.file}: expected a package that `plymotion solid` has made; "
                "`plymotion info` shows others"
            )
        return {
            "name": one.file.stem,
            **found,
            "seconds": sum(provenance["seconds"].values()),
            "warnings": list(provenance["warnings"]),
        }

    def text_of(one: Made) -> str:
        return f"{solid_text(table_of(one))}\n{file_lines(one, [])}"

    def show(made: list[Made], _: list[Request]) -> int:
        return show_each(made, table_of, text_of, as_json=options.json)

    options.out = options.out or FOLDERS["solid"]
    return run_described(
        "solid",
        entries_of(options.files),
        options,
        ["--force"] if options.force else [],
        spec_of=lambda entry: cast(
            dict[str, Any], solid_spec(entry.file, options.material, options.size)
        ),
        show=show,
    )
