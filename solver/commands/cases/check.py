"""The command `plymotion check`."""

import argparse

from ...errors import InputError, counted
from ...inputs.case import load_case
from ...inputs.case.reading.specs import write_case
from ...inputs.manual import case_page


def run_check(options: argparse.Namespace) -> int:
    """Check a case file; with --out, write the input of the other commands."""
    if options.reference:
        print(case_page(), end="")
        return 0
    if options.case is None:
        raise InputError("check: no case file given; expected CASE.toml")
    case = load_case(options.case, coarse=options.coarse)
    if options.out is None:
        print(f"{options.case}: {counted(len(case.runs), 'run')}, no errors")
    else:
        write_case(case, options.out, options.packages)
    return 0
