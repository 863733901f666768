"""The command `plymotion compile`."""

import argparse

from ..studies.compiling import compile_ahead
from ..workers.launch import compile_forms


def run_compile(options: argparse.Namespace) -> int:
    """Compile the step loop; with --all also what other methods and FEniCSx need."""
    print(compile_ahead(everything=options.all), flush=True)
    if options.all:
        print(compile_forms())
    return 0
