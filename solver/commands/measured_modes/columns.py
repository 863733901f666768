"""Columns of numbers from a CSV file with the names in its first line."""

import csv
from pathlib import Path

import numpy as np

from ...errors import InputError, nearest
from ...math.arrays import Array, IntArray


def read_columns(
    file: Path, required: tuple[str, ...], optional: tuple[str, ...]
) -> tuple[IntArray, dict[str, Array]]:
    """Node numbers (n,) of the column `node`, and the other columns by name, (n,) each.

    Empty lines and lines that begin with # are ignored. Values are separated by commas or, if the
    first line contains any, by semicolons.

    Raises
    ------
    InputError : no such file; a column is unknown or missing; a value is not a number; a node
        occurs twice. Names file, line and column.
    """
    rows = _rows(file)
    head_line, head = rows[0]
    known = ("node", *required, *optional)
    for name in head:
        if name not in known:
            raise InputError(f"{file}:{head_line}: column {name!r}: unknown{nearest(name, known)}")
        if head.count(name) > 1:
            raise InputError(f"{file}:{head_line}: column {name!r}: occurs twice")
    for name in ("node", *required):
        if name not in head:
            raise InputError(
                f"{file}:{head_line}: column {name!r}: missing; expected a first line that names "
                f"it, found {', '.join(head)}"
            )
    numbers = np.empty((len(rows) - 1, len(head)))
    for k, (line, texts) in enumerate(rows[1:]):
        if len(texts) != len(head):
            raise InputError(f"{file}:{line}: expected {len(head)} values, found {len(texts)}")
        for j, text in enumerate(texts):
            numbers[k, j] = _number(file, line, head[j], text)
    columns = {name: numbers[:, j] for j, name in enumerate(head)}
    nodes = columns.pop("node").astype(np.int64)
    for k in range(1, len(nodes)):
        if nodes[k] in nodes[:k]:
            raise InputError(f"{file}:{rows[k + 1][0]}: node {nodes[k]} occurs twice")
    return nodes, columns


def _rows(file: Path) -> list[tuple[int, list[str]]]:
    """Numbered non-empty lines, split into stripped texts."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (FileNotFoundError, IsADirectoryError) as error:
        raise InputError(f"{file}: no such file") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{file}: expected text in UTF-8 ({error})") from error
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip(" ,;\t") and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise InputError(f"{file}: expected a line of names and a line for each node")
    separator = ";" if ";" in lines[0][1] else ","
    reader = csv.reader((line for _, line in lines), delimiter=separator, skipinitialspace=True)
    return [
        (number, [text.strip() for text in texts])
        for (number, _), texts in zip(lines, reader, strict=True)
    ]


def _number(file: Path, line: int, column: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value) or (column == "node" and value != round(value)):
        expectation = "a whole number" if column == "node" else "a number with a decimal point"
        raise InputError(
            f"{file}:{line}: column {column!r}: expected {expectation}, found {text!r}"
        )
    return value
