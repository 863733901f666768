"""The commands `plymotion shell` and `solid`: numbers, files and figures from descriptions."""

import argparse
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...inputs.shell_specification import load_shell
from ...math.arrays import Array
from ...package.shell.shell_schema import ShellFile
from ...report.shell.findings import read_shown, shell_json
from ...report.shell.shell_text import shell_text
from ...workers.description_results import Made, entries_of
from .description_command import drawn, file_lines, run_described, show_each

MOST_MODES = 6  # with a figure of their own


def run_shell(options: argparse.Namespace) -> int:
    """Make and show the requested results; returns the exit code."""

    def table_of(one: Made) -> dict[str, object]:
        shell, numbers = read_shown(one.file, shell_json)
        if options.figures:
            figures_of(shell, one.file)
        return numbers

    def text_of(one: Made) -> str:
        shell, text = read_shown(one.file, shell_text)
        figures = [] if options.figures is False else figures_of(shell, one.file)
        return f"{text}\n{file_lines(one, figures)}"

    return run_described(
        "shell",
        entries_of(options.files),
        options,
        [f"--{word}" for word in ("verify", "force") if getattr(options, word)],
        spec_of=lambda entry: load_shell(entry.file, options.buckling, options.bound),
        show=lambda made, _: show_each(made, table_of, text_of, as_json=options.json),
    )


def figures_of(shell: ShellFile, file: Path) -> list[Path]:
    """Draw load cases and modes beside the shell file, or return figures that are up to date."""
    pictures = _pictures(shell)
    if not pictures:
        return []

    def draw() -> list[Path]:
        from ...report.shell.shell_figures import Picture, draw_shapes

        shapes = [Picture(title, name, shape[:, :3], unit) for name, title, shape, unit in pictures]
        return draw_shapes(shell.mesh.nodes_G, shell.mesh.cells, shapes, file.parent)

    return drawn(draw, [file.parent / f"{name}.png" for name, *_ in pictures], file)


def _pictures(shell: ShellFile) -> list[tuple[str, str, Array, str]]:
    """Return name, title, shape and unit of each: load cases, the lowest modes with strain energy,
    and the first buckling shape of each load case."""
    cases, pictures = shell.cases.names, list[tuple[str, str, Array, str]]()
    for case, shape in zip(cases, shell.cases.displacements_G, strict=True):
        pictures.append((case, case, shape, "m"))
    if (modes := shell.modes) is not None:
        hertz, first = modes.frequencies_hz, modes.n_zero
        for row in range(first, min(first + MOST_MODES, len(hertz))):
            name = f"mode-{row - first + 1}"
            title = f"mode {row - first + 1}, {hertz[row]:.5g} Hz"
            pictures.append((name, title, modes.shapes_G[row], ""))
    if (buckled := shell.buckling) is not None:
        for row in np.unique(buckled.case, return_index=True)[1].tolist():
            case = cases[buckled.case[row]]
            title = f"buckling under {case}, factor {buckled.factors[row]:.5g}"
            pictures.append((f"{case}-buckling", title, buckled.shapes_G[row], ""))
    return [
        (
            re.sub(r"[^\w.+-]+", "-", f"{shell.name}-{name}").strip("-."),
            f"{shell.name}: {title}",
            shape,
            unit,
        )
        for name, title, shape, unit in pictures
    ]


def run_solid(options: argparse.Namespace) -> int:
    """Make and show the requested results; returns the exit code."""
    from ...inputs.solid_specification import solid_spec
    from ...report.solid import solid_table, solid_text

    if options.size is not None and not options.size > 0.0:
        raise InputError(f"--size {options.size:g}: expected a length above 0")

    def table_of(one: Made) -> Mapping[str, object]:
        return solid_table(one.file)

    def text_of(one: Made) -> str:
        return f"{solid_text(table_of(one))}\n{file_lines(one, [])}"

    return run_described(
        "solid",
        entries_of(options.files),
        options,
        ["--force"] if options.force else [],
        spec_of=lambda entry: solid_spec(entry.file, options.material, options.size),
        show=lambda made, _: show_each(made, table_of, text_of, as_json=options.json),
    )
