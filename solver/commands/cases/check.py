"""The command `plymotion check`."""

import argparse

from ...errors import InputError, counted
from ...inputs.case.load import load_case, load_whole_case
from ...inputs.case.write import write_case
from ...inputs.manual import case_page


def run_check(options: argparse.Namespace) -> int:
    """Check a case file; with --out, write the input of the other commands."""
    if options.reference:
        print(case_page(), end="")
        return 0
    if options.case is None:
        raise InputError("check: no case file given; expected CASE.toml")
    file = options.case
    case = load_case(file, coarse=True) if options.coarse else load_whole_case(file)
    if options.out is None:
        print(f"{file}: {counted(len(case.runs), 'run')}, no errors")
    else:
        write_case(case, options.out, options.packages)
    return 0
