"""VABS input files (.dat, .sg): a mesh of cells of 3 to 9 nodes with layers and materials.

Numbers only, separated by blanks or commas; text after ! or # is ignored.

    format layers                          1: a layer for each cell; 0: material, theta3, theta1
    timoshenko damping thermal
    curved oblique trapeze vlasov
    k1 k2 k3                               if curved
    cos11 cos21                            if oblique: refused
    nodes cells materials
    node x2 x3                             each node
    cell n1 ... n9                         each cell; n4 = 0: a triangle, with its middles in 5 to 7
    cell layer theta1                      format 1, or: cell material theta3 theta1 (nine values)
    layer material theta3                  format 1
    material kind / constants / density    0 isotropic, 1 orthotropic, 2 anisotropic

With damping, a coefficient follows theta3 of a layer and the density; with thermal = 3, expansions
follow the density. They are read and not used.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray
from ...package.common.anisotropic import UPPER, of_upper
from .per_cell import ABSENT, MOST_NODES, QUADRILATERAL, TRIANGLE, CellSection

UNIFORM = 500.0  # a second theta1 above this says that the first holds for the whole cell
CONSTANTS = {0: 2, 1: 9, 2: 21}
# Rows of VABS's order 11 12 13 22 23 33 of stresses in ours, 11 22 33 23 13 12.
OF_VABS = np.array([0, 3, 5, 4, 2, 1])
ORTHOTROPIC = ("E1", "E2", "E3", "G12", "G13", "G23", "nu12", "nu13", "nu23")


class Numbers:
    """The numbers of a file one after the other, with the line for messages."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self._line = 0
        self._tokens = self._all(file)

    def _all(self, file: Path) -> Iterator[str]:
        try:
            text = file.read_text(encoding="utf-8", errors="replace")
        except OSError as error:
            raise InputError(f"{file}: cannot be read: {error}") from error
        for number, line in enumerate(text.splitlines(), start=1):
            self._line = number
            for comment in "!#":
                line = line.split(comment, 1)[0]
            yield from line.replace(",", " ").split()

    def real(self, what: str) -> float:
        """The next number."""
        token = next(self._tokens, None)
        if token is None:
            raise InputError(f"{self.file}: the file ends before {what}")
        try:
            value = float(token.lower().replace("d", "e"))
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise InputError(f"{self.file}, line {self._line}: {token!r}: expected {what}")
        return value

    def reals(self, count: int, what: str) -> list[float]:
        """The next numbers."""
        return [self.real(what) for _ in range(count)]

    def whole(self, what: str, least: int = 0, most: int | None = None) -> int:
        """The next number, a whole one within bounds."""
        value = self.real(what)
        if value != int(value) or value < least or (most is not None and value > most):
            limit = f" up to {most}" if most is not None else ""
            raise InputError(
                f"{self.file}, line {self._line}: {value:g}: expected {what}, a whole number from "
                f"{least}{limit}"
            )
        return int(value)


def read_vabs(file: Path) -> CellSection:
    """Read a VABS input file.

    Raises
    ------
    InputError
        A number that is missing or out of bounds, with the line; options that are not supported.
    """
    numbers = Numbers(file)
    by_layer = numbers.whole("the format, 0 or 1", 0, 1) == 1
    n_layer = numbers.whole("the number of layers")
    numbers.real("the flag of Timoshenko")
    damping = numbers.whole("the damping flag", 0, 1) == 1
    thermal = numbers.whole("the thermal flag", 0, 3) == 3
    curved, oblique, trapeze, vlasov = (
        numbers.whole(f"the flag {name}", 0, 1)
        for name in ("curved", "oblique", "trapeze", "vlasov")
    )
    k = tuple(numbers.reals(3, "k1, k2, k3")) if curved else (0.0, 0.0, 0.0)
    if oblique:
        cosines = numbers.reals(2, "the cosines of the oblique section")
        if cosines != [1.0, 0.0]:
            raise InputError(
                f"{file}: oblique sections are not supported: expected flag 0 and the section "
                "normal to the beam"
            )
    n_node, n_cell, n_material = (
        numbers.whole(f"the number of {name}", 1) for name in ("nodes", "cells", "materials")
    )
    points = np.full((n_node, 2), np.nan)
    for _ in range(n_node):
        row = numbers.whole("the number of a node", 1, n_node)
        points[row - 1] = numbers.reals(2, f"x2 and x3 of node {row}")
    nodes, kind = _cells(numbers, n_cell, n_node)
    ply, theta1, plies = _orientations(numbers, kind, n_material, n_layer, by_layer, damping)
    materials = _materials(numbers, n_material, damping, thermal)
    missing = np.flatnonzero(np.isnan(points[:, 0]))
    if missing.size:
        raise InputError(f"{file}: node {missing[0] + 1} has no position")
    models = {"trapeze": trapeze, "vlasov": vlasov, "damping": damping, "thermal": thermal}
    for number, _ in plies:
        if number not in materials:
            raise InputError(f"{file}: material {number}: no such material")
    return CellSection(
        file, points, nodes, kind, theta1, ply, plies, materials, (k[0], k[1], k[2]),
        not_computed=[name for name, on in models.items() if on],
    )  # fmt: skip


def _cells(numbers: Numbers, n_cell: int, n_node: int) -> tuple[IntArray, IntArray]:
    nodes = np.full((n_cell, MOST_NODES), ABSENT)
    kind = np.full(n_cell, ABSENT)
    for _ in range(n_cell):
        row = numbers.whole("the number of a cell", 1, n_cell)
        listed = [numbers.whole(f"a node of cell {row}", 0, n_node) - 1 for _ in range(MOST_NODES)]
        if listed[3] == ABSENT:  # corners, 0, middles
            kind[row - 1] = TRIANGLE
            listed = [*listed[:3], *listed[4:7], *[ABSENT] * 3]
        else:
            kind[row - 1] = QUADRILATERAL
        corners = listed[: 3 + kind[row - 1]]
        present = [node for node in listed if node != ABSENT]
        if ABSENT in corners or len(set(present)) < len(present):
            raise InputError(
                f"{numbers.file}: cell {row}: expected 3 or 4 corners, and each node once"
            )
        nodes[row - 1] = listed
    if (kind == ABSENT).any():
        raise InputError(f"{numbers.file}: cell {np.argmin(kind) + 1} has no nodes")
    return nodes, kind


def _orientations(
    numbers: Numbers, kind: IntArray, n_material: int, n_layer: int, by_layer: bool, damping: bool
) -> tuple[IntArray, Array, list[tuple[str, float]]]:
    """Ply of each cell, theta1 (c, 1) or (c, 9), and the plies."""
    n_cell = len(kind)
    if by_layer:
        layer = np.full(n_cell, ABSENT)
        angle = np.zeros((n_cell, 1))
        for _ in range(n_cell):
            row = numbers.whole("the number of a cell", 1, n_cell) - 1
            layer[row] = numbers.whole(f"the layer of cell {row + 1}", 1, n_layer) - 1
            angle[row] = numbers.real(f"theta1 of cell {row + 1}")
        if (layer == ABSENT).any():
            raise InputError(f"{numbers.file}: cell {np.argmin(layer) + 1} has no layer")
        layers: dict[int, tuple[str, float]] = {}
        for _ in range(n_layer):
            row = numbers.whole("the number of a layer", 1, n_layer) - 1
            material = numbers.whole(f"the material of layer {row + 1}", 1, n_material)
            layers[row] = (f"material-{material}", numbers.real(f"theta3 of layer {row + 1}"))
            if damping:
                numbers.real(f"the damping of layer {row + 1}")
        if len(layers) < n_layer:
            raise InputError(f"{numbers.file}: expected {n_layer} layers, each once")
        return layer, angle, [layers[row] for row in range(n_layer)]
    plies: dict[tuple[str, float], int] = {}
    ply, angle = np.zeros(n_cell, dtype=np.int64), np.zeros((n_cell, MOST_NODES))
    for _ in range(n_cell):
        row = numbers.whole("the number of a cell", 1, n_cell) - 1
        material = numbers.whole(f"the material of cell {row + 1}", 1, n_material)
        theta3 = numbers.real(f"theta3 of cell {row + 1}")
        theta1 = np.array(numbers.reals(9, f"theta1 of cell {row + 1}"))
        ply[row] = plies.setdefault((f"material-{material}", theta3), len(plies))
        if theta1[1] > UNIFORM:
            angle[row] = theta1[0]
        elif kind[row] == TRIANGLE:  # in the order of our nodes
            angle[row, :6] = theta1[[0, 1, 2, 4, 5, 6]]
        else:
            angle[row] = theta1
    uniform = bool(np.all(angle[:, 1:] == angle[:, :1]))
    return ply, angle[:, :1] if uniform else angle, list(plies)


def _materials(
    numbers: Numbers, count: int, damping: bool, thermal: bool
) -> dict[str, dict[str, Any]]:
    materials: dict[str, dict[str, Any]] = {}
    for _ in range(count):
        number = numbers.whole("the number of a material", 1, count)
        kind = numbers.whole(f"the kind of material {number}, 0, 1 or 2", 0, 2)
        constants = numbers.reals(CONSTANTS[kind], f"the constants of material {number}")
        rho = numbers.real(f"the density of material {number}")
        if damping:
            numbers.real(f"the damping of material {number}")
        if thermal:
            numbers.reals({0: 1, 1: 3, 2: 6}[kind], f"the expansions of material {number}")
        name = f"material-{number}"
        if kind == 0:
            materials[name] = {"kind": "isotropic", "E": constants[0], "nu": constants[1]}
        elif kind == 1:
            named = dict(zip(ORTHOTROPIC, constants, strict=True))
            materials[name] = {"kind": "orthotropic", **named}
        else:
            C = of_upper(constants)[np.ix_(OF_VABS, OF_VABS)]
            materials[name] = {"kind": "anisotropic", "C": C[UPPER].tolist()}
        materials[name]["rho"] = rho
    if len(materials) < count:
        raise InputError(f"{numbers.file}: expected {count} materials, each once")
    return materials
