"""The command `plymotion sweep`: compute members, or merge the files of shards."""

import argparse
import os
import sys
import time
from pathlib import Path

from ..errors import InputError, few
from ..package.common.files import refuse_foreign, refuse_link, write_text
from ..package.common.plain_data import share
from ..studies.exit_codes import INCOMPLETE
from ..studies.sweep.file import (
    CSV,
    FAILED,
    FILE,
    PENDING,
    STOPPED,
    SweepResult,
    result_of,
    sweep_csv,
)
from ..studies.sweep.portions import RowFile, settled
from ..studies.sweep.sweep_members import read_sweep_spec
from ..studies.sweep.sweep_outcome import draw_sweep, outcome_lines
from ..system.interrupts import INTERRUPTED
from ..workers.executors import executor_of
from .arguments import wanted_formats

SHARDS = "sweep-*-of-*.h5"


def run_sweep(options: argparse.Namespace) -> int:
    """Compute a sweep; return 0, or 3 if a member failed or stopped, 130 if interrupted."""
    if options.merge:
        for name in ("shard", "fresh", "jobs", "executor", "scheduler"):
            if getattr(options, name):
                raise InputError(f"--{name}: expected without --merge, which computes nothing")
        return merged(options)
    sweep = read_sweep_spec(options.sweep, allow_doubtful=options.allow_doubtful)
    folder = _folder(options)
    for name in (FILE, CSV):
        refuse_foreign(folder / name)  # before the work
    planned = settled(sweep)
    file, known = folder / FILE, [folder / FILE, *sorted(folder.glob(SHARDS))]
    if options.shard:
        members = share(sweep.members, options.shard)
        if not members:
            raise InputError(
                "--shard {}/{}: expected at most {} shares, one for each member".format(
                    *options.shard, len(sweep.members)
                )
            )
        sweep = sweep.part(members)
        file = folder / "sweep-{}-of-{}.h5".format(*options.shard)
        known = [folder / FILE, file]
    work = RowFile(sweep, file, [] if options.fresh else known, show=not options.quiet)
    begin = time.perf_counter()
    through = work.compute(lambda: executor_of(options))
    result = result_of(sweep, work.rows)
    seconds = time.perf_counter() - begin
    try:
        if through:
            lines = outcome_lines(result, work.kept, seconds, planned)
            return _told(result, lines, file, options, table=not options.shard)
    except KeyboardInterrupt:
        pass
    total = len(result.rows)
    print(
        f"{result.name}: interrupted; {total - result.count(PENDING)} of {total} members are in "
        f"{file}, the same command continues from there",
        file=sys.stderr,
    )
    return INTERRUPTED


def merged(options: argparse.Namespace) -> int:
    """Merge the files of shards into one; return 0, or 3 if members are missing or incomplete."""
    sweep = read_sweep_spec(options.sweep, allow_doubtful=True)
    folder = _folder(options)
    shards = sorted(folder.glob(SHARDS))
    if not shards:
        raise InputError(f"{folder}: no files {SHARDS}; expected those of `sweep --shard k/N`")
    file = folder / FILE
    work = RowFile(sweep, file, [file, *shards], show=False)
    work.save()
    result = result_of(sweep, work.rows)
    missing = result.count(PENDING)
    lines = outcome_lines(result, work.kept, 0.0)
    code = _told(result, lines, file, options, table=not missing)
    if missing:
        print(
            f"{sweep.name}: {missing} of {len(sweep.members)} members are in none of {len(shards)} "
            f"shards; `plymotion sweep {options.sweep}` computes them",
            file=sys.stderr,
        )
    return INCOMPLETE if missing else code


def _folder(options: argparse.Namespace) -> Path:
    folder: Path = options.out or options.sweep.with_suffix("")
    refuse_link(folder / FILE)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _told(
    result: SweepResult,
    lines: list[str],
    file: Path,
    options: argparse.Namespace,
    *,
    table: bool,
) -> int:
    """Say what became of the members; return the exit code.

    Parameters
    ----------
    table : write the table after the figures, last: it is the sign of a complete sweep
    """
    if table:
        text = sweep_csv(result)
        drawn = draw_sweep(file.parent, result, wanted_formats(options))
        if drawn:
            lines.append(f"  figures: {few(path.name for path in drawn)}")
        write_text(file.parent / CSV, text)
    if table and options.csv:
        print(text, end="")
    else:
        print(f"{lines[0]}; {os.path.relpath(file)}{f', {CSV}' if table else ''}")
        print("\n".join(lines[1:]))
    return INCOMPLETE if result.count(FAILED, STOPPED) else 0
