"""Build the packages that run files and sweep files name."""

import argparse
import sys

from ..cases.packages import BodiesFailed, build_packages, named_packages, needed_specs
from ..executors.choice import executor_of
from ..exit_codes import INCOMPLETE


def run_packages(options: argparse.Namespace) -> int:
    """Build packages; return 0, or 3 if a body could not be built."""
    code = 0
    named = {file: named_packages(file) for file in options.files}
    for folder, specs in needed_specs(named).items():
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
