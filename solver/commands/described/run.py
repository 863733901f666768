"""From descriptions to results files, with progress on the screen."""

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from ...interrupts import INTERRUPTED
from ..executors.choice import executor_of
from .entries import Entry
from .heartbeat import Heartbeat
from .make import Made, Request, SpecOf, make_files, write_specs

Shown = Callable[[list[Made], list[Request]], int]


def run_described(
    command: str,
    entries: Sequence[Entry],
    options: argparse.Namespace,
    words: Sequence[str],
    *,
    spec_of: SpecOf,
    show: Shown,
    list_each: bool = False,
) -> int:
    """Make what is described and show it; returns the exit code.

    Parameters
    ----------
    command, words : of the preprocessor: its command, `section` or `shell`, and options
    entries : results files among them are only shown
    options : out, check, json, quiet, and those of the executor
    spec_of : checks a description and returns its specification
    show : what to do with the results, in the order of the entries; returns the exit code
    list_each : a line for each on standard error where there is no progress bar
    """
    made: dict[str, Made] = {}
    try:
        made |= {e.name: Made(e, e.file, "unchanged") for e in entries if _is_result(e)}
        described = [entry for entry in entries if entry.name not in made]
        requests, failed = write_specs(described, options.out, spec_of)
        made |= {one.entry.name: one for one in failed}
        if not options.check:
            with _Bar(command, made, len(entries), options.quiet, list_each) as bar:
                make_files(
                    requests,
                    command,
                    words,
                    executor=lambda: executor_of(options, threads=True),
                    done=bar.done,
                    progress=bar.progress,
                )
        code = show([made[entry.name] for entry in entries if entry.name in made], requests)
    except KeyboardInterrupt:
        complete = sum(one.status != "failed" for one in made.values())
        print(
            f"interrupted: {complete} of {len(entries)} {command}s are complete and kept; "
            "the same command continues from there",
            file=sys.stderr,
        )
        return INTERRUPTED
    if options.check and not options.json:
        print(f"{len(requests)} of {len(entries)} descriptions are right, see {options.out}")
    return code


def _is_result(entry: Entry) -> bool:
    return entry.file.suffix == ".vtkhdf"


class _Bar:
    """Notes in `made` what became of each, and shows how far the work is."""

    def __init__(
        self, unit: str, made: dict[str, Made], total: int, quiet: bool, list_each: bool
    ) -> None:
        self.made, self.total = made, total
        self.bar: Any = None
        if not quiet and sys.stderr.isatty():
            from tqdm import tqdm  # here: without a terminal nothing is drawn

            self.bar = tqdm(total=total, initial=len(made), unit=unit, leave=False)
        self.list_each = list_each and self.bar is None and not quiet
        self.heartbeat = Heartbeat() if self.bar is None and not quiet else None

    def __enter__(self) -> "_Bar":
        return self

    def __exit__(self, *_: object) -> None:
        if self.heartbeat:
            self.heartbeat.end()
        if self.bar is not None:
            self.bar.close()

    def done(self, one: Made) -> None:
        self.made[one.entry.name] = one
        if self.bar is not None:
            self.bar.update()
        if self.list_each:
            line = f"[{len(self.made)}/{self.total}] {one.entry.name}: {one.status}"
            print(line, file=sys.stderr)

    def progress(self, doing: str) -> None:
        if self.heartbeat:
            self.heartbeat.doing = doing
        if self.bar is not None:  # quick ones begin faster than a screen can be read
            due = time.time() - self.bar.last_print_t > self.bar.mininterval
            self.bar.set_postfix_str(doing, refresh=due)
