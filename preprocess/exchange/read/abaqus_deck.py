"""Nodes, elements and sets of an Abaqus or CalculiX input deck."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import Cells
from ..reduce import rows_of
from .files import text_lines

# Type without its suffixes -> VTK type and number of nodes. The order of the nodes is that of VTK.
SOLIDS = {
    "C3D4": (10, 4),
    "C3D6": (13, 6),
    "C3D8": (12, 8),
    "C3D10": (24, 10),
    "C3D15": (26, 15),
    "C3D20": (25, 20),
}
SHELLS = {"S3": (5, 3), "S4": (9, 4), "S6": (22, 6), "S8": (23, 8), "M3D4": (9, 4)}
TYPES = SOLIDS | SHELLS
SUFFIXES = ("RI", "R", "I", "T", "H")
DEEPEST = 5  # files that include each other


@dataclass
class Deck:
    """Mesh of a deck, in its labels; an element is its type, nodes and set."""

    file: Path
    labels: list[int] = field(default_factory=list)
    points: list[list[float]] = field(default_factory=list)
    elements: dict[int, tuple[str, list[int], str]] = field(
        default_factory=dict
    )  # type, nodes, set
    groups: dict[str, list[int]] = field(default_factory=dict)
    cards: list[tuple[str, dict[str, str], list[list[str]]]] = field(default_factory=list)

    def mesh(self) -> tuple[IntArray, Array, Cells, dict[str, IntArray]]:
        """Labels (n,), coordinates (n, 3), cells, sets of rows."""
        ids = np.array(self.labels, dtype=np.int64)
        known = set(self.labels)
        cells, types = [], []
        for kind, nodes, _ in self.elements.values():
            if kind in TYPES:
                row = rows_of(np.array(nodes), ids, f"{self.file}: *ELEMENT")
                cells.append(row.tolist())
                types.append(TYPES[kind][0])
        groups = {
            name: rows_of(np.array([n for n in nodes if n in known]), ids, str(self.file))
            for name, nodes in self.groups.items()
            if known.intersection(nodes)
        }
        return ids, np.array(self.points), Cells.of(cells, types), groups


def read_deck(file: Path) -> Deck:
    """Read a deck. Raises InputError for a line that is not understood."""
    deck = Deck(file)
    for keyword, options, lines in _cards(file, 0):
        if keyword == "NODE":
            _nodes(deck, options, lines)
        elif keyword == "ELEMENT":
            _elements(deck, options, lines)
        elif keyword == "NSET":
            _set(deck, options, lines)
        else:
            deck.cards.append((keyword, options, lines))
    if not deck.labels:
        raise InputError(f"{file}: no *NODE; expected the deck that was analysed")
    return deck


def _cards(file: Path, depth: int) -> Iterator[tuple[str, dict[str, str], list[list[str]]]]:
    """Keyword, its parameters, and its lines of data, split at commas."""
    if depth > DEEPEST:
        raise InputError(f"{file}: *INCLUDE goes round in a circle")
    keyword, options, rows = "", dict[str, str](), list[list[str]]()
    for line in text_lines(file):
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        if not text.startswith("*"):
            rows.append([part.strip() for part in text.split(",")])
            continue
        if keyword:
            yield keyword, options, rows
        words = [word.strip() for word in text[1:].split(",")]
        keyword, rows = words[0].upper(), []
        pairs = [word.partition("=") for word in words[1:] if word]
        options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
        if keyword == "INCLUDE":
            included = file.parent / options.get("INPUT", "")
            if not included.is_file():
                raise InputError(f"{file}: *INCLUDE: no such file: {included}")
            yield from _cards(included, depth + 1)
            keyword = ""
    if keyword:
        yield keyword, options, rows


def _nodes(deck: Deck, options: dict[str, str], lines: list[list[str]]) -> None:
    for row in lines:
        try:
            label, point = int(row[0]), [float(part or 0.0) for part in row[1:4]]
        except ValueError as error:
            raise InputError(f"{deck.file}: *NODE: {', '.join(row)}: {error}") from error
        deck.labels.append(label)
        deck.points.append([*point, *[0.0] * (3 - len(point))])
        if "NSET" in options:
            deck.groups.setdefault(options["NSET"], []).append(label)


def _elements(deck: Deck, options: dict[str, str], lines: list[list[str]]) -> None:
    name = options.get("TYPE", "").upper()
    kind = next((name.removesuffix(s) for s in SUFFIXES if name.removesuffix(s) in TYPES), name)
    numbers = [int(part) for row in lines for part in row if part]
    if kind not in TYPES:
        deck.elements.update({row: (kind, [], "") for row in (int(r[0]) for r in lines if r[0])})
        return
    size = 1 + TYPES[kind][1]
    if len(numbers) % size:
        raise InputError(
            f"{deck.file}: *ELEMENT, TYPE={name}: {len(numbers)} numbers; expected {size} for each "
            "element"
        )
    for i in range(0, len(numbers), size):
        elset = options.get("ELSET", "")
        deck.elements[numbers[i]] = kind, numbers[i + 1 : i + size], elset


def _set(deck: Deck, options: dict[str, str], lines: list[list[str]]) -> None:
    nodes = deck.groups.setdefault(options.get("NSET", ""), [])
    for row in lines:
        words = [word for word in row if word]
        if "GENERATE" in options:
            first, last, *step = map(int, words)
            nodes += range(first, last + 1, step[0] if step else 1)
            continue
        for word in words:
            if word.isdecimal():
                nodes.append(int(word))
            elif word in deck.groups:
                nodes += deck.groups[word]
