"""Programs of this Python that tests start."""

import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from typing import Any


def this_python(
    *words: object, more: Mapping[str, str] | None = None, **options: Any
) -> "subprocess.CompletedProcess[str]":
    """Run this Python; its output is text. `more`: variables that differ from those of the test.

    The other options are those of `subprocess.run`.
    """
    env = {"env": {**os.environ, **more}} if more else {}
    line = [sys.executable, *map(str, words)]
    return subprocess.run(line, capture_output=True, text=True, **env, **options)


def interrupted(code: str, *words: object) -> tuple[int, str, str]:
    """Run Python text as plain NumPy, with Ctrl-C once it prints "stepping"; exit code, output."""
    with subprocess.Popen(
        [sys.executable, "-c", code, *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PLYMOTION_COMPILED": "0"},
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "stepping\n"
            process.send_signal(signal.SIGINT)
            output, errors = process.communicate(timeout=60)
        finally:
            process.kill()
    return process.returncode, output, errors
