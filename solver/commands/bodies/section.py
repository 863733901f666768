"""The command `plymotion section`: numbers, section files and figures from descriptions."""

import argparse
import glob
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from ...errors import InputError
from ...inputs.common.text_file import read_toml
from ...inputs.section.study import described_spec, study_variants
from ...package.common.files import refuse_foreign
from ...package.common.materials import MaterialError
from ...package.common.plain_data import share
from ...package.section.section_file import read_section
from ...report.section.codes import read_results, write_for
from ...report.section.section_text import (
    Row,
    judged_peaks,
    load_text,
    section_json,
    section_text,
    summary_json,
    summary_text,
    write_summary,
)
from ...report.table import json_text
from ...workers.description_results import Entry, Made, Request, entries_of
from ..arguments import FOLDERS
from .description_command import (
    USER_ERROR,
    drawn,
    file_lines,
    run_described,
    show_each,
    tell_failure,
)

# The sections of a batch: a folder, a pattern, a list, or a study.


def read_list(place: str) -> list[Entry]:
    """Read a batch list.

    Parameters
    ----------
    place : a folder of descriptions (*.toml), a pattern such as "sections/box-*.toml", a study
        (see study.py), or a text file with the name of a description in each line, relative to its
        folder; `#` starts a comment

    Raises
    ------
    InputError : it does not exist, names no section, or is wrong.
    """
    path = Path(place)
    if path.is_dir():
        entries = entries_of(sorted(path.glob("*.toml")))
    elif glob.has_magic(place) and not path.is_file():
        entries = entries_of(Path(name) for name in sorted(glob.glob(place, recursive=True)))
    elif path.suffix == ".toml":
        entries = _study_entries(path)
    else:
        entries = entries_of(path.parent / name for name in _names(path))
    if not entries:
        raise InputError(f"{place}: names no section; expected descriptions (*.toml)")
    return entries


def _names(path: Path) -> list[str]:
    try:
        text = path.read_text(encoding="utf-8")
    except (FileNotFoundError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: not a batch list; expected folder, pattern, study (.toml) or text file"
        ) from error
    return [name for line in text.splitlines() if (name := line.split("#")[0].strip())]


def _study_entries(path: Path) -> list[Entry]:
    table = read_toml(path, "batch list")
    if "mesh" in table:
        raise InputError(f"{path}: this is a section description: use it without --batch")
    study, variants = study_variants(path, table)
    return [
        Entry(base.name + suffix, base.file, changes)
        for base in entries_of(path.parent / name for name in study.sections)
        for suffix, changes in variants
    ]


# The command `plymotion section`: numbers, section files and figures from descriptions.


def run_section(options: argparse.Namespace) -> int:
    """Make and show the requested results; returns the exit code."""

    def show(made: list[Made], requests: list[Request]) -> int:
        if options.batch and not options.check:
            return _summarise(made, options)
        code = _show(made, {request.entry.name: request.title for request in requests}, options)
        if options.to and code == 0 and not options.check:
            files = {one.entry.name: one.file for one in made}
            order = [files[entry.name] for entry in entries]
            for line in write_for(options.to, order, options.stations, options.out):
                print(line, file=sys.stderr if options.json else sys.stdout)
        return code

    flags = ("--no-estimate", "--verify", "--force")
    words = [word for word in flags if getattr(options, word[2:].replace("-", "_"))]
    if options.accuracy is not None:
        words += ["--accuracy", repr(options.accuracy)]
    if options.batch and options.to:
        raise InputError("section: --to is for FILE, also for DIR/*/*.vtkhdf")
    asked = {key: {key: 1.0} for key in options.derivatives}
    entries = _entries(options)
    for suffix in (".csv", ".json") if options.batch and not options.check else ():
        folder = options.out or FOLDERS["section"]
        refuse_foreign(folder / f"{_summary(options)}{suffix}")  # before the work
    return run_described(
        "section",
        entries,
        options,
        words,
        spec_of=lambda entry: described_spec(
            entry.file, entry.changes, entry.name, options.out, asked
        ),
        show=show,
        list_each=bool(options.batch),
    )


def _entries(options: argparse.Namespace) -> list[Entry]:
    if bool(options.files) == bool(options.batch):
        raise InputError("section: expected one or more FILEs, or --batch LIST")
    if options.corner_distance is not None and not options.loads:
        raise InputError("section: --corner-distance is for --loads")
    if options.files:
        if options.shard:
            raise InputError("section: --shard is for --batch LIST")
        return entries_of(options.files)
    if options.loads or options.order != "plymotion":
        raise InputError("section: --loads and --order are for FILE, also for DIR/*/*.vtkhdf")
    return share(read_list(options.batch), options.shard or (1, 1))


def _show(made: Sequence[Made], titles: dict[str, str], options: argparse.Namespace) -> int:
    """Show one section after the other; returns the exit code."""

    def table_of(one: Made) -> dict[str, object]:
        if options.figures:
            figures_of(one.file)
        return section_json(read_results(one.file), options.order)

    def text_of(one: Made) -> str:
        results = read_results(one.file)
        parts = [section_text(results, titles.get(one.entry.name, ""), options.order)]
        if options.loads:
            try:
                section = read_section(one.file)
                peaks, doubts = judged_peaks(section, options.loads, options.corner_distance)
            except MaterialError as error:
                raise InputError(f"{one.file}: {error}") from error
            parts.append(load_text(peaks, options.loads, doubts))
        figures = [] if options.figures is False else figures_of(one.file)
        return "\n\n".join([*parts, file_lines(one, figures)])

    return show_each(made, table_of, text_of, as_json=options.json)


def _summary(options: argparse.Namespace) -> str:
    return "summary" + ("-{}-of-{}".format(*options.shard) if options.shard else "")


def _summarise(made: Sequence[Made], options: argparse.Namespace) -> int:
    """Write and show the table of a batch, report failures; returns the exit code."""
    rows = []
    for one in made:
        results = None if one.status == "failed" else read_results(one.file)
        rows.append(Row(one.entry.name, one.status, one.entry.changes, results, one.error))
        if results is not None and options.figures:
            figures_of(one.file)
    options.out.mkdir(parents=True, exist_ok=True)
    files = write_summary(options.out, _summary(options), rows)
    if options.json:
        print(json_text(summary_json(rows)))
    else:
        print(summary_text(rows))
        counts = Counter(row.status for row in rows)
        counted = ", ".join(
            f"{counts[s]} {s}" for s in ("built", "unchanged", "failed") if counts[s]
        )
        print(f"{counted}; table: {files[0]}, {files[1].name}")
    for one in made:
        if one.status == "failed":
            tell_failure(one)
    return USER_ERROR if any(row.status == "failed" for row in rows) else 0


def figures_of(file: Path) -> list[Path]:
    """Draw the figures of a section file beside it, or return those that are up to date."""

    def draw() -> list[Path]:
        from ...report.section.section_figures import draw_section

        return draw_section(read_section(file), file.parent)

    return drawn(draw, sorted(file.parent.glob("*.png")), file)
