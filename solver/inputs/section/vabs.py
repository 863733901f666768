"""VABS input files (.dat, .sg, .vab): a mesh of cells of 3 to 9 nodes with layers and materials.

One row of numbers for each read:

    format layers                          1: a layer for each cell; else material, theta3, theta1
    timoshenko damping thermal             VABS 4; in VABS 3: timoshenko recover thermal
    curved oblique trapeze vlasov
    k1 k2 k3                               if curved
    cos11 cos21                            if oblique: refused
    nodes cells materials
    node x2 x3                             each node
    cell n1 ... n9                         each cell; n4 = 0: a triangle, with its middles in 5 to 7
    cell layer theta1                      format 1, or: cell material theta3 theta1 (nine values)
    layer material theta3                  format 1
    material kind / constants / density    0 isotropic, 1 orthotropic, 2 anisotropic

Nodes, cells, layers and materials may have any numbers, in any order. Format 1 with 0 layers has
materials in the place of layers. With damping, a coefficient follows theta3 of a layer and the
density; with thermal = 3, expansions follow the density. They are read and not used. What follows
the materials (temperatures, resultants for recovery) is not read.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import InputError, few
from ...math.arrays import Array, IntArray
from ...package.common.materials import UPPER, of_upper
from .becas import (
    ABSENT,
    MOST_NODES,
    ORTHOTROPIC,
    QUADRILATERAL,
    TRIANGLE,
    CellSection,
    Constants,
    cell_section_spec,
    is_becas,
    read_becas,
)

# Rows of numbers in a text file, read as Fortran's list-directed READ does.
#
# Every read begins on a new line, skips empty ones, and ignores what follows the last number that
# it needs. A read that needs more numbers goes on in the next line. Text after ! or # is a
# comment.

REPEATED = re.compile(r"(\d+)\*(\S+)")
NO_LETTER = re.compile(r"([0-9.])([+-]\d+)$")  # 1.5-3 is 1.5e-3
TO_EXPONENT = str.maketrans("dDqQ", "eeee")


class Records:
    """The lines of a file with numbers, and the place of the next read."""

    def __init__(self, file: Path) -> None:
        self.file = file
        try:
            text = file.read_text(encoding="utf-8-sig", errors="replace")
        except OSError as error:
            raise InputError(f"{file}: cannot be read: {error}") from error
        self._lines: list[int] = []
        self._words: list[list[str]] = []
        self.place = 0
        for number, line in enumerate(text.splitlines(), start=1):
            for comment in "!#":
                line = line.split(comment, 1)[0]
            words = line.replace(",", " ").split()
            if words and words != ["\x1a"]:  # the end of a file of DOS
                self._lines.append(number)
                self._words.append(words)

    @property
    def line(self) -> int:
        """Line of the file where the last read ended."""
        return self._lines[self.place - 1] if self.place else 0

    def words(self) -> list[str]:
        """Words of the line of the next read; none at the end of the file."""
        return self._words[self.place] if self.place < len(self._words) else []

    def reals(self, count: int, what: str) -> list[float]:
        """The numbers of one read."""
        numbers: list[float] = []
        while len(numbers) < count:
            if self.place >= len(self._words):
                raise InputError(f"{self.file}: the file ends before {what}")
            words = self._words[self.place]
            self.place += 1
            for word in words:
                repeat = REPEATED.fullmatch(word)
                times, text = (int(repeat[1]), repeat[2]) if repeat else (1, word)
                numbers += [self._real(text, what)] * min(times, count)
                if len(numbers) >= count:
                    break
        return numbers[:count]

    def whole(self, what: str, least: int = 0, most: int | None = None) -> int:
        """A read of one whole number within bounds.

        Parameters
        ----------
        what : what the number is, for messages
        least : least value
        most : largest value; None: any
        """
        return self.wholes([what], least, most)[0]

    def wholes(self, whats: Sequence[str], least: int = 0, most: int | None = None) -> list[int]:
        """Whole numbers within bounds of one read; `whats` says what each one is.

        Parameters
        ----------
        whats : what each number is, for messages
        least : least value
        most : largest value; None: any
        """
        values = self.reals(len(whats), ", ".join(whats))
        limit = f" up to {most}" if most is not None else ""
        for what, value in zip(whats, values, strict=True):
            if value != int(value) or value < least or (most is not None and value > most):
                raise self.wrong(self.line, value, f"{what}, a whole number from {least}{limit}")
        return [int(value) for value in values]

    def wrong(self, line: int, value: float, what: str) -> InputError:
        """The error for a number of a line.

        Parameters
        ----------
        line : line of the file
        value : the number
        what : what was expected
        """
        return InputError(f"{self.file}, line {line}: {value:g}: expected {what}")

    def table(self, rows: int, columns: int, what: str) -> tuple[Array, IntArray]:
        """The numbers of equal reads, (rows, columns), and the line of each.

        Parameters
        ----------
        rows : number of reads
        columns : numbers of each read
        what : what a read is, for messages
        """
        start = self.place
        words = self._words[start : start + rows]
        if len(words) == rows and all(len(row) >= columns for row in words):
            try:
                text = np.array([row[:columns] for row in words])
                values = np.char.replace(np.char.lower(text), "d", "e").astype(float)
            except ValueError:
                values = np.full((rows, columns), np.nan)
            if np.isfinite(values).all():
                self.place += rows
                return values, np.array(self._lines[start : start + rows])
        values, lines = np.empty((rows, columns)), np.empty(rows, dtype=np.int64)
        for row in range(rows):
            values[row] = self.reals(columns, what)
            lines[row] = self.line
        return values, lines

    def _real(self, word: str, what: str) -> float:
        text = NO_LETTER.sub(r"\1e\2", word.translate(TO_EXPONENT))
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise InputError(f"{self.file}, line {self.line}: {word!r}: expected {what}")
        return value


# Tables of numbers whose rows have numbers of their own: nodes, cells, layers of other codes.


@dataclass(frozen=True)
class NumberedRows:
    """Rows in any order, with any numbers from 1, each once; `r` counts rows.

    Attributes
    ----------
    numbers : (r,) number of each row
    values : (r, n) what follows the number
    lines : (r,) line of the file
    """

    records: Records
    what: str
    numbers: IntArray
    values: Array
    lines: IntArray

    @classmethod
    def read(cls, records: Records, count: int, columns: int, what: str) -> "NumberedRows":
        """Read `count` rows of a number and `columns` others; `what` names one row.

        Parameters
        ----------
        records : reads of the file
        count : number of rows
        columns : numbers of each row, without its own number
        what : name of one row
        """
        table, lines = records.table(count, 1 + columns, f"the number and values of a {what}")
        given = table[:, 0]
        for row in np.flatnonzero((given != np.rint(given)) | (given < 1)):
            raise records.wrong(lines[row], given[row], f"the number of a {what}, from 1")
        numbers = given.astype(np.int64)
        order = np.argsort(numbers, kind="stable")
        for row in np.flatnonzero(np.diff(numbers[order]) == 0):
            raise InputError(
                f"{records.file}, line {lines[order[row + 1]]}: {what} {numbers[order[row]]} is "
                f"also in line {lines[order[row]]}"
            )
        return cls(records, what, numbers, table[:, 1:], lines)

    def rows_of(self, given: Array, lines: IntArray, what: str) -> IntArray:
        """Rows with given numbers, which `what` describes for messages.

        Parameters
        ----------
        given : numbers of rows (k,)
        lines : their lines in the file (k,)
        what : what the numbers are, for messages
        """
        order = np.argsort(self.numbers)
        place = np.searchsorted(self.numbers, given, sorter=order)
        rows = order[np.minimum(place, len(order) - 1)]
        for bad in np.flatnonzero(self.numbers[rows] != given):
            least, most = self.numbers.min(), self.numbers.max()
            gaps = " with gaps" if most - least >= len(self.numbers) else ""
            raise self.records.wrong(
                lines[bad], given[bad], f"{what}, one of the numbers {least} to {most}{gaps}"
            )
        return np.asarray(rows, dtype=np.int64)

    def in_order_of(self, others: "NumberedRows") -> "NumberedRows":
        """The same rows in the order of others with the same numbers."""
        rows = others.rows_of(self.numbers.astype(float), self.lines, f"a {others.what}")
        missing = np.setdiff1d(np.arange(len(others.numbers)), rows)
        if missing.size:
            raise InputError(
                f"{self.records.file}: {others.what} {others.numbers[missing[0]]}: expected its "
                f"{self.what}"
            )
        order = np.argsort(rows)
        return NumberedRows(
            self.records, self.what, self.numbers[order], self.values[order], self.lines[order]
        )


UNIFORM = 500.0  # a second theta1 above this says that the first holds for the whole cell
CONSTANTS = {0: 2, 1: 9, 2: 21}
EXPANSIONS = {0: 1, 1: 3, 2: 6}
# Rows of VABS's order 11 12 13 22 23 33 of stresses in ours, 11 22 33 23 13 12.
OF_VABS = np.array([0, 3, 5, 4, 2, 1])
FLAGS = ("curved", "oblique", "trapeze", "vlasov")


@dataclass(frozen=True)
class _Head:
    """What stands above the mesh; `second` is the flag of damping or of recovery."""

    by_layer: bool
    n_layer: int
    second: int
    thermal: int
    models: list[str]
    k: tuple[float, float, float]


def read_vabs(file: Path) -> CellSection:
    """Read a VABS input file.

    Raises
    ------
    InputError
        A number that is missing or out of bounds, with the line; options that are not supported.
    """
    records = Records(file)
    head = _head(records)
    start = records.place
    if head.second == 1:  # damping in VABS 4, recovery in VABS 3: only the rows tell
        try:
            return _section(records, head, damping=True)
        except InputError as error:
            reached = records.place
            records.place = start
            try:
                return _section(records, head, damping=False)
            except InputError:
                if records.place > reached:
                    raise
                raise error from None
    return _section(records, head, damping=False)


def _head(records: Records) -> _Head:
    by_layer = records.words()[:1] == ["1"]
    what = ["the format", "the number of layers"]
    n_layer = records.wholes(what if by_layer else what[:1])[-1]
    what = ["the Timoshenko flag", "the flag of damping or recovery", "the thermal flag"]
    _, second, thermal = records.wholes(what, 0, 3)
    flags = records.wholes([f"the flag {name}" for name in FLAGS], 0, 1)
    k1, k2, k3 = records.reals(3, "k1, k2, k3") if flags[0] else (0.0, 0.0, 0.0)
    if flags[1] and records.reals(2, "the cosines of the oblique section") != [1.0, 0.0]:
        raise InputError(
            f"{records.file}, line {records.line}: oblique sections are not supported, "
            "because the 6x6 belongs to the section normal to the beam: project the nodes along "
            "the beam onto that section, turn the layers with it, and set the flag oblique to 0"
        )
    models = [name for name, on in zip(FLAGS[2:], flags[2:], strict=True) if on]
    return _Head(by_layer, n_layer, second, thermal, models, (k1, k2, k3))


def _section(records: Records, head: _Head, *, damping: bool) -> CellSection:
    n_node, n_cell, n_material = records.wholes(
        ["the number of nodes", "the number of cells", "the number of materials"], 1
    )
    points = NumberedRows.read(records, n_node, 2, "node")
    cells = NumberedRows.read(records, n_cell, MOST_NODES, "cell")
    nodes, kind = _cells(cells, points)
    columns = 2 if head.by_layer else 2 + MOST_NODES
    turned = NumberedRows.read(records, n_cell, columns, "orientation").in_order_of(cells)
    layers = None
    if head.by_layer and head.n_layer:
        layers = NumberedRows.read(records, head.n_layer, 2 + damping, "layer")
    materials, lines = _materials(records, n_material, damping, head.thermal == 3)
    if layers is not None:
        of_cells = layers.rows_of(turned.values[:, 0], turned.lines, "a layer")
        source, rows = layers, layers.values[:, :2]
    else:
        of_cells = np.arange(n_cell)
        source, rows = turned, turned.values[:, :2].copy()
        if head.by_layer:
            rows[:, 1] = 0.0
    for bad in np.flatnonzero(~np.isin(rows[:, 0], list(materials))):
        listed = few(sorted(map(str, materials)))
        what = f"the material of a {source.what}, one of {listed}"
        raise records.wrong(source.lines[bad], rows[bad, 0], what)
    unique, ply = np.unique(rows, axis=0, return_inverse=True)
    models = [*head.models]
    models += ["damping" if damping else "recovery"] if head.second else []
    models += ["thermal"] if head.thermal else []
    return CellSection(
        records.file,
        points.values,
        nodes,
        kind,
        turned.values[:, 1:] if head.by_layer else _theta1(turned.values[:, 2:], kind),
        ply.ravel()[of_cells],
        [(f"material-{number:.0f}", float(angle)) for number, angle in unique],
        {f"material-{number}": table for number, table in materials.items()},
        head.k,
        not_computed=models,
        places={
            f"material-{number}": f"{records.file}, line {line}: material {number}"
            for number, line in lines.items()
        },
    )


def _cells(cells: NumberedRows, points: NumberedRows) -> tuple[IntArray, IntArray]:
    """Nodes of each cell in our order, and its kind."""
    nodes = np.full(cells.values.shape, ABSENT)
    row, column = np.nonzero(cells.values)
    nodes[row, column] = points.rows_of(cells.values[row, column], cells.lines[row], "a node")
    kind = np.where(nodes[:, 3] == ABSENT, TRIANGLE, QUADRILATERAL)
    triangle = kind == TRIANGLE  # corners, 0, middles
    nodes[triangle, 3:6], nodes[triangle, 6:] = nodes[triangle, 4:7], ABSENT
    ordered = np.sort(nodes, axis=1)
    twice = ((np.diff(ordered, axis=1) == 0) & (ordered[:, 1:] != ABSENT)).any(axis=1)
    for bad in np.flatnonzero((nodes[:, :3] == ABSENT).any(axis=1) | twice):
        raise InputError(
            f"{cells.records.file}, line {cells.lines[bad]}: cell {cells.numbers[bad]}: expected 3 "
            "or 4 corners, and each node once"
        )
    return nodes, kind


def _theta1(given: Array, kind: IntArray) -> Array:
    """theta1 (c, 1), or (c, 9) at the nodes in our order where it turns inside cells."""
    angle = given.copy()
    triangle = kind == TRIANGLE
    angle[triangle, 3:6], angle[triangle, 6:] = given[triangle, 4:7], given[triangle, :1]
    uniform = given[:, 1] > UNIFORM
    angle[uniform] = given[uniform, :1]
    return angle[:, :1] if (angle == angle[:, :1]).all() else angle


def _materials(
    records: Records, count: int, damping: bool, thermal: bool
) -> tuple[dict[int, Constants], dict[int, int]]:
    """Constants of each material by its number, and the line where they begin."""
    materials: dict[int, Constants] = {}
    lines: dict[int, int] = {}
    for _ in range(count):
        number, kind = records.wholes(["the number of a material", "its kind, 0, 1 or 2"])
        where = f"material {number}"
        if kind not in CONSTANTS:
            raise records.wrong(records.line, kind, f"the kind of {where}, 0, 1 or 2")
        if number in materials:
            raise InputError(f"{records.file}, line {records.line}: {where} was given before")
        lines[number] = records.line
        constants = records.reals(CONSTANTS[kind], f"the constants of {where}")
        rho = records.reals(1, f"the density of {where}")[0]
        if damping:
            records.reals(1, f"the damping of {where}")
        if thermal:
            records.reals(EXPANSIONS[kind], f"the expansions of {where}")
        materials[number] = _constants(kind, constants) | {"rho": rho}
    return materials, lines


def _constants(kind: int, constants: list[float]) -> Constants:
    if kind == 0:
        return {"kind": "isotropic", "E": constants[0], "nu": constants[1]}
    if kind == 1:
        return {"kind": "orthotropic", **dict(zip(ORTHOTROPIC, constants, strict=True))}
    C = of_upper(constants)[np.ix_(OF_VABS, OF_VABS)]
    return {"kind": "anisotropic", "C": C[UPPER].tolist()}


VABS = (".dat", ".sg", ".vab", ".vabs")  # suffixes of VABS input


def is_of_another_code(file: Path) -> bool:
    """Return True for a VABS input file and for a folder of BECAS input."""
    return is_becas(file) or (file.suffix.lower() in VABS and file.is_file())


def spec_of_another_code(file: Path, folder: Path) -> dict[str, object]:
    """Return the specification of a section of another code; arrays are written to a folder.

    Raises
    ------
    InputError
        The file is not what it should be.
    """
    section = read_becas(file) if is_becas(file) else read_vabs(file)
    return cell_section_spec(section, folder)
