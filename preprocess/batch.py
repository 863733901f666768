"""Process many specifications in one process, which shares imports, compiled forms and meshes.

A `Product` (modal packages of bodies, section files) makes one file from one specification. This
file has what all products share: reading, skipping files that are up to date, errors that do not
stop the others, progress as lines for people or as one JSON object per line.
"""

import dataclasses
import json
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

USER_ERROR = 2


class BatchError(Exception):
    """A specification that cannot be read."""


Made = tuple[str, Sequence[dict[str, str]]]  # a one-line summary, and the coded warnings


class Product(Protocol):
    """Makes one file from one specification."""

    def unchanged(self, target: Path, spec: Mapping[str, object]) -> bool:
        """True if the target is a valid file made from the same inputs."""

    def make(self, spec: Mapping[str, object], target: Path) -> Made:
        """Write the target."""


@dataclass(frozen=True)
class Outcome:
    """Result of one specification."""

    spec: str
    file: str
    status: str  # "built", "unchanged", "failed"
    seconds: float
    text: str = ""  # summary of a file that was built
    warnings: tuple[dict[str, str], ...] = ()  # {"code", "message"}
    error: str = ""  # in one line
    defect: str = ""  # traceback of an internal error


def _build(product: Product, path: Path, target: Path, *, force: bool = False) -> Outcome:
    """Make the file of one specification; an error becomes part of the outcome.

    Raises
    ------
    ImportError : FEniCSx is missing, so all other specifications would fail too.
    """
    start = time.perf_counter()

    def outcome(status: str, **more: Any) -> Outcome:
        seconds = time.perf_counter() - start
        return Outcome(str(path), str(target), status, seconds, **more)

    try:
        spec = _read(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        if not force and product.unchanged(target, spec):
            return outcome("unchanged")
        text, warnings = product.make(spec, target)
        return outcome("built", text=text, warnings=tuple(warnings))
    except ImportError:
        raise
    except Exception as error:
        # those with a message for the user are ours, and of the operating system
        own = type(error).__module__.startswith("plymotion.") or isinstance(error, OSError)
        defect = "" if own else traceback.format_exc()
        line = " ".join(str(error).split()) or type(error).__name__
        return outcome("failed", error=line, defect=defect)


def build_all(
    product: Product,
    specs: Sequence[Path],
    target_of: Callable[[Path], Path],
    *,
    force: bool = False,
    report: "Callable[[Outcome, str], None] | None" = None,
) -> int:
    """Make the file of every specification, one after the other; returns the exit code.

    Parameters
    ----------
    specs : JSON files
    target_of : the file that a specification becomes
    force : build also files that are up to date
    report : called with each outcome and its number ("3/14"); `print_outcome` by default
    """
    report = report or print_outcome
    code = 0
    for count, path in enumerate(specs, start=1):
        outcome = _build(product, path, target_of(path), force=force)
        report(outcome, f"{count}/{len(specs)}")
        if outcome.status == "failed":
            code = USER_ERROR
    return code


def print_outcome(outcome: Outcome, place: str) -> None:
    """Print one line of progress on stdout, and warnings and errors, one line each, on stderr."""
    name = Path(outcome.file).stem
    for warning in outcome.warnings:
        text = f"warning: {name}: {warning['code']}: {warning['message']}"
        print(text, file=sys.stderr, flush=True)
    if outcome.status != "failed":
        print(f"[{place}] {name}: {outcome.text or outcome.status}", flush=True)
        return
    if outcome.defect:
        print(outcome.defect, end="", file=sys.stderr)
        print("this is an error of the preprocessor, not of the input:", file=sys.stderr)
    print(f"error: {outcome.spec}: {outcome.error}", file=sys.stderr, flush=True)


def _read(path: Path) -> Mapping[str, object]:
    try:
        spec = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise BatchError("no such file") from error
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise BatchError(f"not JSON: {error}") from error
    if not isinstance(spec, dict):
        raise BatchError(f"expected a JSON object, found {type(spec).__name__}")
    return spec


Report = Callable[[Outcome, str], None]
Progress = Callable[[str], None]


@contextmanager
def reporter(as_json: bool, first: bool) -> Iterator[tuple[Report, Progress | None]]:
    """Reporter of outcomes and progress: only the first rank reports, as text or as JSON.

    Lines of JSON go to the original standard output, immediately and as a whole; output of
    libraries goes to standard error.
    """
    if not first:
        yield lambda _outcome, _place: None, None
        return
    if not as_json:
        yield print_outcome, None
        return
    sys.stdout.flush()
    lines = os.dup(1)
    os.dup2(2, 1)

    def write(content: dict[str, object]) -> None:
        os.write(lines, (json.dumps(content) + "\n").encode())

    try:
        yield (
            lambda outcome, _place: write(dataclasses.asdict(outcome)),
            lambda line: write({"progress": line}),
        )
    finally:
        sys.stdout.flush()
        os.dup2(lines, 1)
        os.close(lines)
