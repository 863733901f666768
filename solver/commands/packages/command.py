"""Build the packages that run files and sweep files name."""

import argparse
import json
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..cases.packages import BodiesFailed, build_packages
from ..executors.choice import executor_of

INCOMPLETE = 3


def run_packages(options: argparse.Namespace) -> int:
    """Build packages; return 0, or 3 if a body could not be built."""
    code = 0
    for folder, specs in _specs(options.files).items():
        try:
            build_packages(
                specs,
                folder,
                executor=lambda: executor_of(options, threads=True),
                quiet=options.quiet,
            )
        except BodiesFailed as error:
            print(f"error: {error}", file=sys.stderr)
            code = INCOMPLETE
    return code


def _specs(files: Sequence[Path]) -> dict[Path, list[Path]]:
    """Return the specifications that some files need, each once, by folder."""
    found: dict[Path, dict[Path, None]] = {}
    for file in files:
        for entry in _entries(file):
            if "inputs_sha256" in entry:  # others are packages of the user
                spec = file.parent.parent / Path(entry["file"]).with_suffix(".json")
                found.setdefault(spec.parent, {})[spec] = None
    return {folder: list(specs) for folder, specs in found.items()}


def _entries(file: Path) -> Iterable[dict[str, Any]]:
    """Return the entries of packages of a run or sweep file. Raises InputError."""
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
        packages = table["packages"]
        entries = packages if isinstance(packages, list) else list(packages.values())
        entries += table.get("check_packages", {}).values()
        if not all(isinstance(entry["file"], str) for entry in entries):
            raise ValueError("packages: expected the names of files")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(
            f"{file}: not a run or sweep file ({error}); expected one written by `plymotion check`"
        ) from error
    return entries
