"""The command `plymotion shell`: from descriptions to numbers, shell files and figures."""

import argparse
import json
import re
import sys
import time
from pathlib import Path
from typing import Any

from tqdm import tqdm

from ...errors import InputError
from ...package.common.materials import MaterialError
from ...package.shell.io import read_shell
from ...package.shell.schema import ShellFile
from .make import Made, Request, make_shells, write_specs
from .show import shell_text
from .show_json import shell_json

USER_ERROR = 2
INTERRUPTED = 130
MOST_MODES = 6  # with a figure of their own


def run_shell(options: argparse.Namespace) -> int:
    """Make and show what the options ask for; returns the exit code."""
    made: dict[Path, Made] = {}
    try:
        return _run(options, made)
    except KeyboardInterrupt:
        complete = sum(one.status != "failed" for one in made.values())
        print(
            f"interrupted: {complete} of {len(options.files)} shells are complete and kept",
            file=sys.stderr,
        )
        return INTERRUPTED


def _run(options: argparse.Namespace, made: dict[Path, Made]) -> int:
    """Fill `made`, by description, and show it."""
    files = list(dict.fromkeys(options.files))
    made |= {file: Made(file, file, "unchanged") for file in files if file.suffix == ".vtkhdf"}
    requests, failed = write_specs([file for file in files if file not in made], options.out)
    made |= {one.description: one for one in failed}
    if not options.check:
        _make(requests, options, made)
    code = _show([made[file] for file in files if file in made], options)
    if options.check and not options.json:
        print(f"{len(requests)} of {len(files)} descriptions are right, see {options.out}")
    return code


def _make(requests: list[Request], options: argparse.Namespace, made: dict[Path, Made]) -> None:
    """Have the shell files made and note in `made` what became of each."""
    with tqdm(
        total=len(requests),
        unit="shell",
        leave=False,
        disable=True if options.quiet else None,  # None: where there is no terminal
    ) as bar:

        def done(one: Made) -> None:
            made[one.description] = one
            bar.update()

        def progress(doing: str) -> None:
            if not bar.disable:
                due = time.time() - bar.last_print_t > bar.mininterval
                bar.set_postfix_str(doing, refresh=due)

        make_shells(requests, force=options.force, done=done, progress=progress)


def _show(made: list[Made], options: argparse.Namespace) -> int:
    """Show one shell after the other; returns the exit code."""
    tables: dict[str, Any] = {}
    code = 0
    for one in made:
        name = one.description.stem
        if one.status == "failed":
            code = USER_ERROR
            tell_failure(one)
            tables[name] = {"error": one.error}
            continue
        shell = read_shell(one.file)
        try:
            if options.json:
                tables[name] = shell_json(shell)
                if options.figures:
                    figures_of(shell, one.file)
            else:
                parts = [shell_text(shell), _files(shell, one, options)]
                print("\n".join(parts), end="\n" if one is made[-1] else "\n\n")
        except MaterialError as error:
            raise InputError(f"{one.file}: {error}") from error
    if options.json and tables and not (code and len(made) == 1):
        print(json.dumps(next(iter(tables.values())) if len(made) == 1 else tables))
    return code


def _files(shell: ShellFile, one: Made, options: argparse.Namespace) -> str:
    figures = [] if options.figures is False else figures_of(shell, one.file)
    note = " (unchanged)" if one.status == "unchanged" else ""
    first = f"{'Files':16}{one.file}{note}"
    return "\n".join([first, *(f"{'':16}{figure}" for figure in figures)])


def tell_failure(one: Made) -> None:
    """Say on standard error why a shell has not been made."""
    if one.defect:
        print(one.defect, end="", file=sys.stderr)
        print("this is a defect of the preprocessor, not of the input:", file=sys.stderr)
    for line in one.error.splitlines():
        print(f"error: {line}", file=sys.stderr)


def figures_of(shell: ShellFile, file: Path) -> list[Path]:
    """Draw load cases and modes beside the shell file, or return figures that are up to date."""
    names = _figure_names(shell)
    drawn = [file.parent / f"{name}.png" for name in names]
    made = file.stat().st_mtime
    if all(figure.is_file() and figure.stat().st_mtime >= made for figure in drawn):
        return drawn
    try:
        from .figures import Picture, draw_shapes  # here: matplotlib takes its time

        shapes = [*((case, "m") for case in shell.cases.displacements_G)]
        titles = [f"{shell.name}: {name}" for name in shell.cases.names]
        if shell.modes is not None:
            hertz = shell.modes.frequencies_hz
            for row in _drawn_modes(shell):
                shapes.append((shell.modes.shapes_G[row], ""))
                number = row - shell.modes.n_zero + 1
                titles.append(f"{shell.name}: mode {number}, {hertz[row]:.5g} Hz")
        pictures = [
            Picture(title, name, shape[:, :3], unit)
            for title, name, (shape, unit) in zip(titles, names, shapes, strict=True)
        ]
        return draw_shapes(shell.mesh.nodes_G, shell.mesh.cells, pictures, file.parent)
    except (InputError, ModuleNotFoundError) as error:  # the numbers are there all the same
        print(f"no figures: {error}; they need pip install plymotion[plot]", file=sys.stderr)
        return []


def _drawn_modes(shell: ShellFile) -> range:
    """Rows of the lowest modes with strain energy."""
    if shell.modes is None:
        return range(0)
    first = shell.modes.n_zero
    return range(first, min(first + MOST_MODES, len(shell.modes.frequencies)))


def _figure_names(shell: ShellFile) -> list[str]:
    modes = [f"mode-{number + 1}" for number in range(len(_drawn_modes(shell)))]
    parts = (f"{shell.name}-{name}" for name in (*shell.cases.names, *modes))
    return [re.sub(r"[^\w.+-]+", "-", part).strip("-.") for part in parts]
