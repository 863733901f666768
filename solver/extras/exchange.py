"""The exchange of bodies with other codes, which is a part of the preprocessor, in this Python.

The solver does not import the preprocessor. It starts it as a process, as it does with FEniCSx; the
two exchange files only. This part of the preprocessor needs no FEniCSx, so the Python is the same.
"""

import logging
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from ..package.validation import write_valid
from ..system.interrupts import INTERRUPTED
from ..workers.launch import environment, importable

MEASURED = "measured"
LOGGER = logging.getLogger(__name__)
ENDED = 70  # exit code of a process that a signal has ended


def import_body(
    file: Path, out: Path, source: str | None = None, *, quiet: bool = False, show: bool = True
) -> tuple[int, str]:
    """Make a modal package from a body of another code; return as `exchange`.

    Parameters
    ----------
    file : names the files of the other code (docs/exchange.md)
    source : the other code; None: its key `from`; "measured": `file` has measured modes
        (docs/modes.md), which this process reads
    """
    if source == MEASURED:
        from .measured_modes import measured_package  # Pydantic takes longer than an export

        package = measured_package(file)
        write_valid(out, package, str(file))
        for warning in package.provenance["warnings"]:
            LOGGER.warning("warning [%s] %s", warning["code"], warning["message"])
        return 0, f"{out}: {package.body}, {package.n_mode} measured modes"
    words = ["import", str(file), "--out", str(out)]
    words += ["--from", source] if source else []
    code, text = exchange([*words, *(["--quiet"] if quiet else [])], show=show)
    for line in text.splitlines():
        if line.startswith("warning"):
            LOGGER.warning("%s", line)
    return code, text


def export_body(
    package: Path, target: str, out: Path | None = None, *, show: bool = True
) -> tuple[int, str]:
    """Write a modal package in the format of another code; return as `exchange`.

    Parameters
    ----------
    package : file of the package
    target : name of the format
    out : file to write; None: beside the package
    show : print what is written
    """
    words = ["export", str(package), "--to", target]
    return exchange([*words, *(["--out", str(out)] if out else [])], show=show)


def exchange(words: Sequence[str], *, show: bool = True) -> tuple[int, str]:
    """Run `python -m plymotion.preprocess.exchange`; return its exit code and its messages.

    Parameters
    ----------
    show : write its output to that of this process; no messages are returned then
    """
    with importable() as folder:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "plymotion.preprocess.exchange", *words],
            env=environment(folder),
            stdout=None if show else subprocess.DEVNULL,
            stderr=None if show else subprocess.PIPE,
            text=True,
        )
        try:
            _, text = process.communicate()
        except KeyboardInterrupt:  # the terminal has interrupted both
            process.wait()
            return INTERRUPTED, ""
    code = process.returncode
    if code < 0:
        how = signal.strsignal(-code) or f"signal {-code}"
        return ENDED, f"error: {words[0]} of {words[1]}: the process was ended: {how}"
    return code, text or ""
