"""Shells of CalculiX by their modes: the deck, and the .frd file of a *FREQUENCY step.

CalculiX expands shells to solids. The file has the nodes of the deck and those of the expansion;
with `*NODE FILE, OUTPUT=2D` the values at the former are those of the middle surface.
"""

from pathlib import Path

import numpy as np

from ....solver.errors import InputError
from ....solver.math.arrays import Array
from ..faces import SHARES, face_area
from ..free_body import Cells
from ..modal import ModalBody
from .abaqus_deck import SHELLS, Deck, read_deck
from .files import Files, text_lines

WIDTH, FIRST = 12, 13  # columns of a value, and of the first one


def read(files: Files) -> ModalBody:
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
    return ModalBody(
        where=files.where,
        nodes=nodes,
        node_ids=ids,
        cells=cells,
        shapes=shapes,
        has_rotations=False,
        hertz=hertz,
        damping_ratios=np.zeros(len(hertz)),
        mass=_masses(deck, nodes, cells),
        groups=groups,
    )


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
