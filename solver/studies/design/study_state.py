"""The state of a study: what was computed of each design, a line each, in one file.

Processes append whole lines, so the file is right at any time. An optimiser that begins again asks
for the same designs in the same order; those that are known cost nothing, and it goes on where it
was stopped.
"""

import hashlib
import json
import logging
import os
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...math.arrays import Array

FILE = "study.jsonl"
FORMAT = "plymotion study"
LOGGER = logging.getLogger(__name__)


class Memory:
    """What is known of designs, by kind ("values", "slopes") and parameters.

    Parameters
    ----------
    key : digest of what the numbers depend on; a file with another one is begun anew
    """

    def __init__(self, file: Path, key: str, *, fresh: bool = False) -> None:
        self.file, self.key, self.known = file, key, dict[tuple[str, str], Any]()
        head = _sealed({"format": FORMAT, "key": key})
        lines = [] if fresh or not file.is_file() else file.read_text("utf-8").splitlines()
        if lines and lines[0] != head:
            LOGGER.info("%s: what it depends on has changed; designs are computed again", file)
        if not lines or lines[0] != head:
            if lines and FORMAT not in lines[0]:
                raise InputError(f"{file}: was not written by `plymotion optimise`; remove it")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(head + "\n", encoding="utf-8")
            lines = []
        elif not file.read_bytes().endswith(b"\n"):  # a line that a killed process left
            with file.open("ab") as out:
                out.write(b"\n")
        for line in lines[1:]:
            entry = _opened(line)
            if entry is not None:
                self.known[entry["kind"], entry["x"]] = entry["found"]

    def get(self, kind: str, p: Array) -> Any:
        """Return what is known of a design, None for nothing."""
        return self.known.get((kind, _text(p)))

    def put(self, kind: str, p: Array, value: Any) -> None:
        """Keep what was computed of a design.

        Parameters
        ----------
        kind : "values" or "slopes"
        p : (p,) parameters of the design
        value : plain data that JSON can keep
        """
        self.known[kind, _text(p)] = value
        line = _sealed({"kind": kind, "x": _text(p), "found": value}) + "\n"
        out = os.open(self.file, os.O_WRONLY | os.O_APPEND)
        try:
            os.write(out, line.encode())
        finally:
            os.close(out)


def _text(p: Array) -> str:
    return ",".join(map(repr, map(float, p)))  # exact


def _sealed(entry: dict[str, object]) -> str:
    text = json.dumps(entry)
    return f"{hashlib.sha256(text.encode()).hexdigest()[:16]} {text}"


def _opened(line: str) -> Any:
    """Return the content of a whole line; None of a torn or altered one."""
    digest, _, text = line.partition(" ")
    if hashlib.sha256(text.encode()).hexdigest()[:16] != digest:
        return None
    return json.loads(text)
