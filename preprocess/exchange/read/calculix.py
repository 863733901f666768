"""Bodies of CalculiX: solids by matrices, shells by modes, with the deck that was analysed.

The matrices are those of `*FREQUENCY, SOLVER=MATRIXSTORAGE`. CalculiX expands shells to solids: the
.frd file has the nodes of the deck and those of the expansion; with `*NODE FILE, OUTPUT=2D` the
values at the former are those of the middle surface.
"""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..faces import SHARES, face_area
from ..free_body import Cells, FreeBody
from ..from_matrices import free_body
from ..modal import ModalBody
from .abaqus_deck import SHELLS, SOLIDS, Deck, read_deck
from .files import Files, text_lines

BESIDE = {"stiffness": ".sti", "mass": ".mas", "dofs": ".dof"}


def read(files: Files) -> FreeBody:
    """Body from `deck` (.inp); .sti, .mas and .dof are beside it or given.

    Raises InputError for a deck with shells (CalculiX expands them to solids, so the labels of the
    matrices are ambiguous), or files that do not belong together.
    """
    files.only(("deck",), tuple(BESIDE))
    deck = read_deck(files.path("deck"))
    for label, (kind, _, _) in deck.elements.items():
        if kind not in SOLIDS:
            hint = 'import shells by their modes, from = "calculix-modes"'
            raise InputError(
                f"{deck.file}: element {label} of type {kind}: expected solids "
                f"({', '.join(SOLIDS)}){'; ' + hint if kind in SHELLS else ''}"
            )
    for key, suffix in BESIDE.items():
        if key not in files:
            files.table = {**files.table, key: str(Path(files.table["deck"]).with_suffix(suffix))}
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


WIDTH, FIRST = 12, 13  # columns of a value, and of the first one


def read_modes(files: Files) -> ModalBody:
    """Body from `deck` (.inp) and `modes` (.frd, absent: beside the deck).

    Raises InputError for other elements than shells, sections without a thickness, or a file
    without modes.
    """
    files.only(("deck",), ("modes",))
    deck = read_deck(files.path("deck"))
    for label, (kind, _, _) in deck.elements.items():
        if kind not in SHELLS:
            raise InputError(f"{deck.file}: element {label} of type {kind}: expected shells")
    if "modes" not in files:
        files.table = {**files.table, "modes": str(Path(files.table["deck"]).with_suffix(".frd"))}
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
                shapes.append(np.zeros((len(row_of), 6)))
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
    surface: dict[str, float] = {}  # set of elements -> mass per area
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
        for _, material in plies:
            if material not in density:
                raise InputError(f"{deck.file}: *MATERIAL, NAME={material}: no *DENSITY")
        total = sum(thickness * density[material] for thickness, material in plies)
        surface[options.get("ELSET", "").upper()] = total
    mass = np.zeros(len(nodes))
    for (label, (_, _, elset)), (_, rows) in zip(deck.elements.items(), cells.each(), strict=True):
        if elset.upper() not in surface:
            raise InputError(
                f"{deck.file}: element {label}: no *SHELL SECTION with ELSET={elset or '(none)'}"
            )
        share = np.array(SHARES[len(rows)])
        mass[rows] += surface[elset.upper()] * face_area(nodes[rows]) * share
    return mass
