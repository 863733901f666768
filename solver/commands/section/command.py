"""The command `plymotion section`: from descriptions to numbers, section files and figures."""

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from ...errors import InputError
from ...inputs.section.study import Entry
from ...package.common.materials import MaterialError
from ...package.common.shares import share
from ...package.section.io import read_section
from .batch_list import entries_of, read_list
from .make import Made, Request, make_sections, write_specs
from .ply_peaks import ply_peaks
from .results import read_results
from .show import section_json, section_text
from .show_loads import load_text
from .summary import Row, summary_json, summary_text, write_summary

USER_ERROR = 2
INTERRUPTED = 130


def run_section(options: argparse.Namespace) -> int:
    """Make and show what the options ask for; returns the exit code."""
    entries = _entries(options)
    made: dict[str, Made] = {}
    try:
        return _run(entries, options, made)
    except KeyboardInterrupt:
        complete = sum(one.status != "failed" for one in made.values())
        print(
            f"interrupted: {complete} of {len(entries)} sections are complete and kept; "
            "the same command goes on from there",
            file=sys.stderr,
        )
        return INTERRUPTED


def _run(entries: list[Entry], options: argparse.Namespace, made: dict[str, Made]) -> int:
    """Fill `made`, by name, and show it."""
    made |= {e.name: Made(e, e.file, "unchanged") for e in entries if e.file.suffix == ".vtkhdf"}
    described = [entry for entry in entries if entry.name not in made]
    requests, failed = write_specs(described, options.out)
    made |= {one.entry.name: one for one in failed}
    if not options.check:
        _make(requests, options, made, total=len(entries))
    in_order = [made[entry.name] for entry in entries if entry.name in made]
    if options.batch and not options.check:
        return _summarise(in_order, options)
    show = _Screen(options, {request.entry.name: request.title for request in requests})
    code = show.sections(in_order)
    if options.check and not options.json:
        print(f"{len(requests)} of {len(entries)} descriptions are right, see {options.out}")
    return code


def _entries(options: argparse.Namespace) -> list[Entry]:
    if bool(options.files) == bool(options.batch):
        raise InputError("section: expected one or more FILEs, or --batch LIST")
    if options.files:
        if options.shard:
            raise InputError("section: --shard is for --batch LIST")
        return entries_of(options.files)
    if options.loads or options.order != "plymotion":
        raise InputError("section: --loads and --order are for FILE, also for DIR/*/*.vtkhdf")
    return share(read_list(options.batch), options.shard or (1, 1))


def _make(
    requests: list[Request], options: argparse.Namespace, made: dict[str, Made], total: int
) -> None:
    """Have the section files made and note in `made` what became of each."""
    words = []
    if options.accuracy is not None:
        words += ["--accuracy", repr(options.accuracy)]
    words += [word for word in ("--no-estimate", "--force") if getattr(options, _name(word))]
    with tqdm(
        total=total,
        initial=len(made),
        unit="section",
        leave=False,
        disable=True if options.quiet else None,  # None: where there is no terminal
    ) as bar:

        def done(one: Made) -> None:
            made[one.entry.name] = one
            bar.update()
            if options.batch and bar.disable and not options.quiet:
                print(f"[{len(made)}/{total}] {one.entry.name}: {one.status}", file=sys.stderr)

        def progress(doing: str) -> None:
            if not bar.disable:  # quick sections begin faster than a screen can be read
                due = time.time() - bar.last_print_t > bar.mininterval
                bar.set_postfix_str(doing, refresh=due)

        make_sections(requests, words, jobs=options.jobs, done=done, progress=progress)


def _name(word: str) -> str:
    return word.lstrip("-").replace("-", "_")


class _Screen:
    """Shows one section after the other."""

    def __init__(self, options: argparse.Namespace, titles: dict[str, str]) -> None:
        self.options = options
        self.titles = titles

    def sections(self, made: Sequence[Made]) -> int:
        """Show all of them; returns the exit code."""
        tables: dict[str, Any] = {}
        code = 0
        for one in made:
            if one.status == "failed":
                code = USER_ERROR
                tell_failure(one)
                tables[one.entry.name] = {"error": one.error}
            elif self.options.json:
                tables[one.entry.name] = section_json(read_results(one.file), self.options.order)
                if self.options.figures:
                    figures_of(one.file)
            else:
                print(self._text(one), end="\n" if one is made[-1] else "\n\n")
        if self.options.json and not (code and len(made) == 1):
            print(json.dumps(next(iter(tables.values())) if len(made) == 1 else tables))
        return code

    def _text(self, one: Made) -> str:
        results = read_results(one.file)
        parts = [section_text(results, self.titles.get(one.entry.name, ""), self.options.order)]
        if self.options.loads:
            try:
                peaks = ply_peaks(read_section(one.file).recovery, self.options.loads)
            except MaterialError as error:
                raise InputError(f"{one.file}: {error}") from error
            parts.append(load_text(peaks, self.options.loads))
        figures = [] if self.options.figures is False else figures_of(one.file)
        files = [one.file, *figures]
        note = " (unchanged)" if one.status == "unchanged" else ""
        parts.append(
            "\n".join(
                f"{'Files' if i == 0 else '':16}{file}{note if i == 0 else ''}"
                for i, file in enumerate(files)
            )
        )
        return "\n\n".join(parts)


def _summarise(made: Sequence[Made], options: argparse.Namespace) -> int:
    """Write and show the table of a batch, tell failures; returns the exit code."""
    rows = []
    for one in made:
        results = None if one.status == "failed" else read_results(one.file)
        rows.append(Row(one.entry.name, one.status, one.entry.changes, results, one.error))
        if results is not None and options.figures:
            figures_of(one.file)
    options.out.mkdir(parents=True, exist_ok=True)
    part = "-{}-of-{}".format(*options.shard) if options.shard else ""
    files = write_summary(options.out, f"summary{part}", rows)
    if options.json:
        print(json.dumps(summary_json(rows)))
    else:
        print(summary_text(rows))
        counts = Counter(row.status for row in rows)
        told = ", ".join(f"{counts[s]} {s}" for s in ("built", "unchanged", "failed") if counts[s])
        print(f"{told}; table: {files[0]}, {files[1].name}")
    for one in made:
        if one.status == "failed":
            tell_failure(one)
    return USER_ERROR if any(row.status == "failed" for row in rows) else 0


def tell_failure(one: Made) -> None:
    """Say on standard error why a section has not been made."""
    if one.defect:
        print(one.defect, end="", file=sys.stderr)
        print("this is a defect of the preprocessor, not of the input:", file=sys.stderr)
    for line in one.error.splitlines():
        print(f"error: {line}", file=sys.stderr)


def figures_of(file: Path) -> list[Path]:
    """Draw the figures of a section file beside it, or return those that are up to date."""
    folder = file.parent
    drawn = sorted(folder.glob("*.png"))
    if drawn and all(figure.stat().st_mtime >= file.stat().st_mtime for figure in drawn):
        return drawn
    try:
        from .figures.section import draw_section  # here: matplotlib takes its time

        return draw_section(read_section(file), folder)
    except (InputError, ModuleNotFoundError) as error:  # the numbers are there all the same
        print(f"no figures: {error}; they need pip install plymotion[plot]", file=sys.stderr)
        return []
