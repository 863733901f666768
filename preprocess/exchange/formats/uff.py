"""Nodes and modes as a universal file: datasets 15 or 2411, and 55; masses as CSV beside it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ....solver.errors import InputError, printable
from ....solver.math.arrays import Array
from ....solver.package import ModalPackage
from ....solver.package.common.files import write_text
from ..free_body import Cells, ModalBody, rows_of
from ..import_table import Files, fortran_number, text_lines
from .modal import write_masses

NORMAL_MODE, DISPLACEMENT, REAL = 2, 8, 2


def read(files: Files) -> ModalBody:
    """Body from `uff` and `masses` (CSV: node, mass and inertias).

    Raises InputError for complex modes, nodes in a coordinate system of their own, and files
    without nodes or modes.
    """
    files.only(("uff", "masses"))
    path = files.path("uff")
    nodes: dict[int, list[float]] = {}
    modes: list[tuple[float, float, dict[int, list[float]]]] = []
    axes = {0, 1}  # numbers of the global axes in 2411, unless 2420 gives 1 others
    for kind, lines in sorted(_datasets(path), key=lambda dataset: -dataset[0]):
        if kind == 2420:
            for head, *turn in zip(*(lines[k::6] for k in (2, 4, 5, 6)), strict=True):
                cosines = [_numbers(row, 25) for row in turn]
                is_global = int(head[10:20]) == 0 and np.array_equal(cosines, np.eye(3))
                (axes.add if is_global else axes.discard)(int(head[:10]))
        elif kind == 15:
            for line in lines:
                nodes[_global(path, line, {0})] = _numbers(line[40:])
        elif kind == 2411:
            for head, data in zip(lines[::2], lines[1::2], strict=True):
                nodes[_global(path, head, axes)] = _numbers(data, 25)
        elif kind == 55:
            modes.append(_mode(path, lines))
    if not nodes or not modes:
        raise InputError(
            f"{path}: {len(nodes)} nodes and {len(modes)} modes; expected datasets 15 and 55"
        )
    modes.sort(key=lambda mode: mode[0])
    ids = np.array(sorted(nodes), dtype=np.int64)
    shapes = np.zeros((len(modes), len(ids), 6))
    widest = 0
    for shape, mode in zip(shapes, modes, strict=True):
        rows = rows_of(np.array(list(mode[2]), dtype=np.int64), ids, str(path))
        values = np.array(list(mode[2].values()))
        shape[:, : values.shape[1]] = np.nan  # of a node without values
        shape[rows, : values.shape[1]] = values
        widest = max(widest, values.shape[1])
    places, cells = np.array([nodes[int(i)] for i in ids]), Cells.points(len(ids))
    hertz, ratios = (np.array([mode[k] for mode in modes]) for k in (0, 1))
    return ModalBody(files.where, places, ids, cells, shapes, hertz, widest == 6, ratios)


def _global(path: Path, line: str, axes: set[int]) -> int:
    """Label of a node whose coordinates and displacements have global axes, of these numbers."""
    if not {int(line[10:20]), int(line[20:30])} <= axes:
        raise InputError(f"{path}: node {line[:10].strip()}: expected global axes")
    return int(line[:10])


def _datasets(path: Path) -> list[tuple[int, list[str]]]:
    """Number and lines of each dataset between two lines -1."""
    datasets: list[tuple[int, list[str]]] = []
    inside: list[str] | None = None
    for line in text_lines(path):
        if line.strip() == "-1":
            if inside:
                datasets.append((int(inside[0].split()[0].rstrip("b")), inside[1:]))
            inside = None if inside is not None else []
        elif inside is not None:
            inside.append(line)
    if inside:
        raise InputError(f"{path}: truncated: the last dataset has no end (a line -1)")
    return datasets


def _mode(path: Path, lines: list[str]) -> tuple[float, float, dict[int, list[float]]]:
    """Frequency [Hz], damping ratio, and values by label of a dataset 55."""
    _, analysis, _, quantity, kind, size = (int(word) for word in lines[5].split()[:6])
    if (analysis, quantity, kind) != (NORMAL_MODE, DISPLACEMENT, REAL) or size not in (3, 6):
        raise InputError(
            f"{path}: dataset 55 with analysis {analysis}, quantity {quantity}, numbers {kind}, "
            f"{size} at a node; expected real displacements of normal modes "
            f"({NORMAL_MODE}, {DISPLACEMENT}, {REAL}), 3 or 6 at a node"
        )
    hertz, _, ratio, _ = _numbers(lines[7])[:4]
    data, k = dict[int, list[float]](), 8
    while k < len(lines):
        label, values = int(lines[k].split()[0]), list[float]()
        while len(values) < size:
            k += 1
            values += _numbers(lines[k])
        data[label] = values
        k += 1
    return hertz, ratio, data


def _numbers(line: str, width: int = 13) -> list[float]:
    """Numbers of fixed width, or separated by blanks."""
    words = line.split()
    fixed = [line[i : i + width].strip() for i in range(0, len(line.rstrip()), width)]
    try:
        return [fortran_number(word) for word in (words if len(words) > 1 else fixed)]
    except ValueError:
        return [fortran_number(word) for word in fixed if word]


SUFFIX = ".uff"
COLOUR, GLOBAL = 1, 0


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write SI units, nodes and one dataset 55 per mode (six numbers per node).

    Parameters
    ----------
    package, source : see contract.py
    out : the file; the masses of the nodes go into a table beside it
    """
    text = "\n".join(line for block in _blocks(package) for line in ["    -1", *block, "    -1"])
    write_text(out, text + "\n", encoding="ascii")
    masses = write_masses(package, out)
    return f"{package.n_mode} modes at {len(package.nodes_B)} nodes; masses in {masses.name}"


def _blocks(package: ModalPackage) -> Iterator[list[str]]:
    units = f"{1:10d}{'SI: Meter (newton)':<20}{2:10d}"
    ones, zero = _in_columns([1.0, 1.0, 1.0], "25.17E"), _in_columns([273.15], "25.17E")
    yield ["   164", units, ones, zero]
    lines = ["    15"]
    for label, point in zip(package.node_ids, package.nodes_B, strict=True):
        lines.append(f"{label:10d}{GLOBAL:10d}{GLOBAL:10d}{COLOUR:10d}{_in_columns(point)}")
    yield lines
    for i, shape in enumerate(package.shapes_B):
        yield list(_mode_lines(package, i, shape))


def _mode_lines(package: ModalPackage, i: int, shape: Array) -> Iterator[str]:
    label = package.mode_labels[i] if package.mode_labels else package.mode_kinds[i]
    w, damping = float(package.frequencies[i]), float(package.damping[i, i])
    ratio = damping / (2.0 * w * package.mass[i, i]) if w else 0.0
    yield "    55"
    yield from (printable(package.body)[:79], printable(label)[:79], "NONE", "NONE", "NONE")
    # structural model, normal mode, six dofs, displacement, real numbers, six per node
    yield "".join(f"{k:10d}" for k in (1, 2, 3, 8, 2, 6))
    yield "".join(f"{k:10d}" for k in (2, 4, 0, i + 1))
    yield _in_columns([w / (2.0 * np.pi), package.mass[i, i], ratio, 0.0])
    for node, values in zip(package.node_ids, shape, strict=True):
        yield f"{node:10d}"
        yield _in_columns(values)


def _in_columns(values: Array | list[float], form: str = "13.5E") -> str:
    return "".join(f"{value:{form}}" for value in values)
