"""Start the exchange with other codes, which is a part of the preprocessor, in this Python.

The solver does not import the preprocessor. It starts it as a process, as it does with FEniCSx; the
two exchange files only. This part of the preprocessor needs no FEniCSx, so the Python is the same.
"""

import argparse
import subprocess
import sys
from collections.abc import Sequence

from ..fenicsx_side.launch import environment, importable

INTERRUPTED = 130


def run_import(options: argparse.Namespace) -> int:
    """Run `plymotion import`; returns the exit code."""
    words = ["import", str(options.file), "--out", str(options.out)]
    words += ["--from", options.source] if options.source else []
    return exchange([*words, *(["--quiet"] if options.quiet else [])])


def exchange(words: Sequence[str]) -> int:
    """Run `python -m plymotion.preprocess.exchange`; its output is that of this process."""
    with importable() as folder:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "plymotion.preprocess.exchange", *words],
            env=environment(folder),
        )
        try:
            return process.wait()
        except KeyboardInterrupt:  # the terminal has interrupted both
            process.wait()
            return INTERRUPTED
