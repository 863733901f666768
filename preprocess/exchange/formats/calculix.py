"""Bodies of CalculiX: solids by matrices, shells by modes, with the deck that was analysed.

Decks are those of Abaqus, too: nodes, elements and sets are read.

The matrices are those of `*FREQUENCY, SOLVER=MATRIXSTORAGE`. CalculiX expands shells to solids: the
.frd file has the nodes of the deck and those of the expansion; with `*NODE FILE, OUTPUT=2D` the
values at the former are those of the middle surface.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import Cells, FreeBody, ModalBody, free_body, rows_of
from ..import_table import Files, fortran_number, text_lines
from ..imported_interfaces import SHARES, face_area

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
BESIDE = {"stiffness": ".sti", "mass": ".mas", "dofs": ".dof"}
WIDTH, FIRST = 12, 13  # columns of a value, and of the first one


@dataclass
class Deck:
    """Mesh of a deck, in its labels; an element is its type and nodes, `sets` are of elements."""

    file: Path
    labels: list[int] = field(default_factory=list)
    points: list[list[float]] = field(default_factory=list)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    groups: dict[str, list[int]] = field(default_factory=dict)
    sets: dict[str, list[int]] = field(default_factory=dict)
    cards: list[tuple[str, dict[str, str], list[list[str]]]] = field(default_factory=list)

    def mesh(self) -> tuple[IntArray, Array, Cells, dict[str, IntArray]]:
        """Labels (n,), coordinates (n, 3), cells, sets of rows."""
        ids = np.array(self.labels, dtype=np.int64)
        known = set(self.labels)
        cells, types = [], []
        for kind, nodes in self.elements.values():
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
        elif keyword in ("NSET", "ELSET"):
            known = deck.groups if keyword == "NSET" else deck.sets
            _set(deck, keyword, known, options, lines)
        else:
            deck.cards.append((keyword, options, lines))
    if not deck.labels:
        raise InputError(f"{file}: no *NODE; expected the deck that was analysed")
    return deck


def _cards(file: Path, depth: int) -> Iterator[tuple[str, dict[str, str], list[list[str]]]]:
    """Keyword, its parameters, and its lines of data, split at commas."""
    if depth > DEEPEST:
        raise InputError(f"{file}: *INCLUDE goes round in a circle")
    keyword, options, rows, text = "", dict[str, str](), list[list[str]](), ""
    for line in text_lines(file):
        if not line.strip() or line.strip().startswith("**"):
            continue
        goes_on = text.startswith("*") and text.endswith(",")
        text = (text if goes_on else "") + line.strip()
        if not text.startswith("*"):
            rows.append([part.strip() for part in text.split(",")])
            continue
        if keyword and not goes_on:
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
    first = len(deck.labels)
    if options.get("SYSTEM", "R").upper() != "R":
        raise InputError(f"{deck.file}: *NODE, SYSTEM={options['SYSTEM']}: expected x, y, z")
    for row in lines:
        try:
            label, point = int(row[0]), [fortran_number(part or "0") for part in row[1:4]]
        except ValueError as error:
            raise InputError(f"{deck.file}: *NODE: {', '.join(row)}: {error}") from error
        deck.labels.append(label)
        deck.points.append([*point, *[0.0] * (3 - len(point))])
    if lines and "NSET" in options:
        _named(deck.groups, options["NSET"]).extend(deck.labels[first:])


def _elements(deck: Deck, options: dict[str, str], lines: list[list[str]]) -> None:
    name = options.get("TYPE", "").upper()
    kind = next((name.removesuffix(s) for s in SUFFIXES if name.removesuffix(s) in TYPES), name)
    numbers = [int(part) for row in lines for part in row if part]
    if kind not in TYPES:
        deck.elements.update({row: (kind, []) for row in (int(r[0]) for r in lines if r[0])})
        return
    size = 1 + TYPES[kind][1]
    if len(numbers) % size:
        raise InputError(
            f"{deck.file}: *ELEMENT, TYPE={name}: {len(numbers)} numbers; expected {size} for each "
            "element"
        )
    for i in range(0, len(numbers), size):
        deck.elements[numbers[i]] = kind, numbers[i + 1 : i + size]
    if numbers:
        _named(deck.sets, options.get("ELSET", "")).extend(numbers[::size])


def _named(sets: dict[str, list[int]], name: str) -> list[int]:
    """The set of this name, in capitals or not; a new one if there is none."""
    same = (known for known in sets if known.upper() == name.upper())
    return sets.setdefault(next(same, name), [])


def _set(
    deck: Deck,
    keyword: str,
    known: dict[str, list[int]],
    options: dict[str, str],
    lines: list[list[str]],
) -> None:
    """Labels of a set of nodes or elements; `known` are the others of its kind."""
    members = _named(known, options.get(keyword, ""))
    for row in lines:
        words = [word for word in row if word]
        if "GENERATE" in options:
            first, last, *step = map(int, words)
            members += range(first, last + 1, step[0] if step else 1)
            continue
        for word in words:
            labels = [int(word)] if word.isdecimal() else list(_named(known, word))
            if not labels:
                raise InputError(
                    f"{deck.file}: *{keyword}, {keyword}={options.get(keyword, '')}: {word}: "
                    "expected a number, or the name of a set that is defined before"
                )
            members += labels


def read(files: Files) -> FreeBody:
    """Body from `deck` (.inp); .sti, .mas and .dof are beside it or given.

    Raises InputError for a deck with shells (CalculiX expands them to solids, so the labels of the
    matrices are ambiguous), or files that do not belong together.
    """
    files.only(("deck",), tuple(BESIDE))
    deck = read_deck(files.path("deck"))
    for label, (kind, _) in deck.elements.items():
        if kind not in SOLIDS:
            hint = 'import shells by their modes, from = "calculix-modes"'
            raise InputError(
                f"{deck.file}: element {label} of type {kind}: expected solids "
                f"({', '.join(SOLIDS)}){'; ' + hint if kind in SHELLS else ''}"
            )
    for key, suffix in BESIDE.items():
        files.beside_deck(key, suffix)
    ids, nodes, cells, groups = deck.mesh()
    dofs = _dofs(files.path("dofs"))
    K, M = (_matrix(files.path(key), len(dofs)) for key in ("stiffness", "mass"))
    return free_body(files.where, K, M, nodes, ids, dofs, cells, groups=groups, notes=files.notes())


def _dofs(path: Path) -> IntArray:
    """Label of the node and direction of each row: lines such as `12.3`, read as text."""
    pairs = []
    for number, line in enumerate(text_lines(path), 1):
        node, dot, direction = line.strip().partition(".")
        if not (dot and node.isdecimal() and direction.isdecimal()):
            raise InputError(f"{path}:{number}: expected node.direction, found {line.strip()!r}")
        pairs.append((int(node), int(direction)))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _matrix(path: Path, size: int) -> sp.csr_matrix:
    """One triangle, counted from 1, as `row column value`; completed to the whole matrix."""
    try:
        table: Array = np.fromstring(path.read_text(), sep=" ").reshape(-1, 3)
    except ValueError as error:
        raise InputError(f"{path}: expected lines `row column value` ({error})") from error
    if not len(table):
        raise InputError(f"{path}: empty; did the analysis end without an error?")
    rows, columns = (table[:, k].astype(np.int64) - 1 for k in (0, 1))
    if max(rows.max(), columns.max()) >= size or min(rows.min(), columns.min()) < 0:
        raise InputError(
            f"{path}: row {max(rows.max(), columns.max()) + 1}, but the file of degrees of freedom "
            f"has {size} lines: do the files belong to one analysis?"
        )
    if (rows > columns).any() and (rows < columns).any():
        raise InputError(f"{path}: expected one triangle, found entries on both sides")
    one = sp.coo_matrix((table[:, 2], (rows, columns)), (size, size)).tocsr()
    return sp.csr_matrix(one + one.T - sp.diags(one.diagonal()))


def read_modes(files: Files) -> ModalBody:
    """Body from `deck` (.inp) and `modes` (.frd, absent: beside the deck).

    Raises InputError for other elements than shells, sections without a thickness, or a file
    without modes.
    """
    files.only(("deck",), ("modes",))
    deck = read_deck(files.path("deck"))
    for label, (kind, _) in deck.elements.items():
        if kind not in SHELLS:
            raise InputError(f"{deck.file}: element {label} of type {kind}: expected shells")
    files.beside_deck("modes", ".frd")
    ids, nodes, cells, groups = deck.mesh()
    hertz, shapes = _modes(files.path("modes"), {int(label): k for k, label in enumerate(ids)})
    mass = _masses(deck, nodes, cells)
    return ModalBody(files.where, nodes, ids, cells, shapes, hertz, mass=mass, groups=groups)


def _modes(path: Path, row_of: dict[int, int]) -> tuple[Array, Array]:
    """Frequencies (m,) and shapes (m, n, 6) of all displacement blocks of modes."""
    hertz, shapes = list[float](), list[Array]()
    value, inside = 0.0, False
    for line in text_lines(path):
        if line.startswith("  100CL"):
            value = float(line[12:24])
            mode = "MODAL" in line
            inside = False
        elif line.startswith(" -4"):
            inside = mode and line[5:13].strip() == "DISP"
            if inside:
                hertz.append(value)
                shapes.append(np.full((len(row_of), 6), [np.nan] * 3 + [0.0] * 3))
        elif line.startswith(" -3"):
            inside = False
        elif inside and line.startswith(" -1"):
            label = int(line[3:FIRST])
            if label in row_of:
                parts = [line[FIRST + WIDTH * k : FIRST + WIDTH * (k + 1)] for k in range(3)]
                shapes[-1][row_of[label], :3] = [float(part) for part in parts]
    if not hertz:
        raise InputError(
            f"{path}: no displacements of modes; expected *FREQUENCY and *NODE FILE, U"
        )
    return np.array(hertz), np.array(shapes)


def _masses(deck: Deck, nodes: Array, cells: Cells) -> Array:
    """Mass of each node from areas, thicknesses and densities, (n,)."""
    density, name = dict[str, float](), ""
    surface: dict[int, float] = {}  # element -> mass per area
    for keyword, options, lines in deck.cards:
        if keyword == "MATERIAL":
            name = options.get("NAME", "").upper()
        elif keyword == "DENSITY":
            density[name] = float(lines[0][0])
    for keyword, options, lines in deck.cards:
        if keyword != "SHELL SECTION":
            continue
        plies = [(float(row[0]), options.get("MATERIAL", "").upper()) for row in lines[:1]]
        if "COMPOSITE" in options:
            plies = [(float(row[0]), row[2].upper()) for row in lines]
        if not plies or "NODAL THICKNESS" in options:
            raise InputError(f"{deck.file}: *SHELL SECTION: expected its thickness in a data line")
        for _, material in plies:
            if material not in density:
                raise InputError(f"{deck.file}: *MATERIAL, NAME={material}: no *DENSITY")
        total = sum(thickness * density[material] for thickness, material in plies)
        surface.update(dict.fromkeys(_named(deck.sets, options.get("ELSET", "")), total))
    mass = np.zeros(len(nodes))
    for label, (_, rows) in zip(deck.elements, cells.each(), strict=True):
        if label not in surface:
            raise InputError(f"{deck.file}: element {label}: no *SHELL SECTION has it in its ELSET")
        mass[rows] += surface[label] * face_area(nodes[rows]) * np.array(SHARES[len(rows)])
    return mass
