"""The commands `plymotion shell` and `solid`: numbers, files and figures from descriptions."""

import argparse
import re
from pathlib import Path
from typing import Any, cast

import numpy as np

from ...errors import InputError
from ...inputs.shell_specification import load_shell
from ...package.shell.schema import ShellFile
from ...report.shell.findings import read_shown, shell_json
from ...report.shell.show import shell_text
from ...workers.described import Made, entries_of
from .described import drawn, each, file_lines, run_described

MOST_MODES = 6  # with a figure of their own


def run_shell(options: argparse.Namespace) -> int:
    """Make and show the requested results; returns the exit code."""

    def table_of(one: Made) -> dict[str, Any]:
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
        show=each(table_of, text_of, options),
    )


def figures_of(shell: ShellFile, file: Path) -> list[Path]:
    """Draw load cases and modes beside the shell file, or return figures that are up to date."""
    names = _figure_names(shell)
    if not names:
        return []

    def draw() -> list[Path]:
        from ...report.shell.figures import Picture, draw_shapes

        shapes = [*((case, "m") for case in shell.cases.displacements_G)]
        titles = [f"{shell.name}: {name}" for name in shell.cases.names]
        if shell.modes is not None:
            hertz = shell.modes.frequencies_hz
            for row in _drawn_modes(shell):
                shapes.append((shell.modes.shapes_G[row], ""))
                number = row - shell.modes.n_zero + 1
                titles.append(f"{shell.name}: mode {number}, {hertz[row]:.5g} Hz")
        if shell.buckling is not None:
            for row in _drawn_buckling(shell):
                shapes.append((shell.buckling.shapes_G[row], ""))
                case = shell.cases.names[shell.buckling.case[row]]
                factor = shell.buckling.factors[row]
                titles.append(f"{shell.name}: buckling under {case}, factor {factor:.5g}")
        pictures = [
            Picture(title, name, shape[:, :3], unit)
            for title, name, (shape, unit) in zip(titles, names, shapes, strict=True)
        ]
        return draw_shapes(shell.mesh.nodes_G, shell.mesh.cells, pictures, file.parent)

    return drawn(draw, [file.parent / f"{name}.png" for name in names], file)


def _drawn_modes(shell: ShellFile) -> range:
    """Rows of the lowest modes with strain energy."""
    if shell.modes is None:
        return range(0)
    first = shell.modes.n_zero
    return range(first, min(first + MOST_MODES, len(shell.modes.frequencies)))


def _drawn_buckling(shell: ShellFile) -> list[int]:
    """Row of the first load factor of each load case."""
    if shell.buckling is None:
        return []
    return [int(row) for row in np.unique(shell.buckling.case, return_index=True)[1]]


def _figure_names(shell: ShellFile) -> list[str]:
    modes = [f"mode-{number + 1}" for number in range(len(_drawn_modes(shell)))]
    buckled = []
    if shell.buckling is not None:
        cases = [shell.cases.names[case] for case in shell.buckling.case]
        buckled = [f"{cases[row]}-buckling" for row in _drawn_buckling(shell)]
    parts = (f"{shell.name}-{name}" for name in (*shell.cases.names, *modes, *buckled))
    return [re.sub(r"[^\w.+-]+", "-", part).strip("-.") for part in parts]


def run_solid(options: argparse.Namespace) -> int:
    """Make and show the requested results; returns the exit code."""
    from ...inputs.solid_specification import solid_spec
    from ...report.solid import solid_table, solid_text

    if options.size is not None and not options.size > 0.0:
        raise InputError(f"--size {options.size:g}: expected a length above 0")

    def text_of(one: Made) -> str:
        return f"{solid_text(solid_table(one.file))}\n{file_lines(one, [])}"

    return run_described(
        "solid",
        entries_of(options.files),
        options,
        ["--force"] if options.force else [],
        spec_of=lambda entry: cast(
            dict[str, Any], solid_spec(entry.file, options.material, options.size)
        ),
        show=each(lambda one: solid_table(one.file), text_of, options),
    )
