"""Nodes and elements of a NASTRAN bulk data file, in small, large and free field format."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import Cells
from ..reduce import rows_of
from .files import text_lines

# Card -> number of corners; first field of the nodes; number of nodes -> VTK type
ELEMENTS = {
    "CQUAD4": (3, {4: 9}),
    "CQUADR": (3, {4: 9}),
    "CTRIA3": (3, {3: 5}),
    "CTRIAR": (3, {3: 5}),
    "CTETRA": (3, {4: 10, 10: 24}),
    "CPENTA": (3, {6: 13, 15: 26}),
    "CHEXA": (3, {8: 12, 20: 25}),
    "CBAR": (3, {2: 3}),
    "CBEAM": (3, {2: 3}),
    "CROD": (3, {2: 3}),
}
# NASTRAN lists the nodes on vertical edges before those of the upper face, VTK after them.
ORDER = {25: [*range(12), *range(16, 20), *range(12, 16)], 26: [*range(9), 12, 13, 14, 9, 10, 11]}
Card = tuple[str, list[str]]  # name and fields
EXPONENT = re.compile(r"(?<=[0-9.])([+-]\d+)$")


def read_bulk_data(path: Path, cards: Sequence[Card]) -> tuple[IntArray, Array, Cells]:
    """Labels in ascending order (n,), coordinates (n, 3), cells.

    Parameters
    ----------
    path : of the deck, for messages
    cards : `bulk_cards` of it

    Raises InputError for nodes in a coordinate system of their own, and scalar points.
    """
    points: dict[int, list[float]] = {}
    cells: list[list[int]] = []
    types: list[int] = []
    for card, fields in cards:
        if card == "GRID":
            label = int(fields[0])
            if any(fields[k] not in ("", "0") for k in (1, 5) if k < len(fields)):
                raise InputError(
                    f"{path}: GRID {label} has a coordinate system of its own (CP or CD); expected "
                    "the basic one"
                )
            values = [*fields[2:5], "", "", ""][:3]
            points[label] = [real(text, path, card) for text in values]
        elif card == "SPOINT":
            raise InputError(f"{path}: SPOINT: expected grid points only")
        elif card in ELEMENTS:
            start, kinds = ELEMENTS[card]
            listed = fields[start - 1 : start - 1 + max(kinds)]
            nodes = [int(text) for text in listed if _whole(text)]
            size = max((k for k in kinds if k <= len(nodes)), default=0)
            if not size:
                raise InputError(f"{path}: {card} {fields[0]}: expected {min(kinds)} nodes")
            kind = kinds[size]
            order = ORDER.get(kind, range(size))
            cells.append([nodes[k] for k in order])
            types.append(kind)
    if not points:
        raise InputError(f"{path}: no GRID; expected bulk data")
    ids = np.array(sorted(points), dtype=np.int64)
    rows = [rows_of(np.array(cell), ids, str(path)).tolist() for cell in cells]
    return ids, np.array([points[int(i)] for i in ids]), Cells.of(rows, types)


def bulk_cards(path: Path) -> Iterator[Card]:
    """Name and fields of each card; continuation lines are joined."""
    lines = [line.split("$")[0].rstrip() for line in text_lines(path)]
    begin = [i for i, line in enumerate(lines) if line.upper().startswith("BEGIN")]
    card, fields = "", list[str]()
    for line in lines[begin[0] + 1 if begin else 0 :]:
        if not line.strip():
            continue
        name, more = _fields(line.expandtabs())
        if name == "" or name[0] in "+*":
            fields += more
            continue
        if card:
            yield card, fields
        card, fields = name, more
        if card == "ENDDATA":
            return
    if card:
        yield card, fields


def _fields(line: str) -> tuple[str, list[str]]:
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        name, data = words[0].upper(), words[1:9]
        return name.rstrip("*") if name[:1] != "*" else name, data + [""] * (8 - len(data))
    large = "*" in line[:8]
    width, count = (16, 4) if large else (8, 8)
    data = [line[8 + width * k : 8 + width * (k + 1)].strip() for k in range(count)]
    name = line[:8].strip().upper()
    return name.rstrip("*") if name[:1] != "*" else name, data


def _whole(text: str) -> bool:
    return text.isdecimal() and int(text) > 0


def real(text: str, path: Path, card: str) -> float:
    """A number of NASTRAN: the E of an exponent may be missing."""
    if not text:
        return 0.0
    number = text.upper().replace("D", "E")
    try:
        return float(number if "E" in number else EXPONENT.sub(r"E\1", number))
    except ValueError as error:
        raise InputError(f"{path}: {card}: expected a number, found {text!r}") from error
