"""Stiffness and mass of VABS 4.1, entry by entry on its own meshes (tests/reference/sections/vabs).

VABS prints eleven digits. Both codes have the same functions and integration points there.
"""

import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.inputs.section.vabs import spec_of_another_code
from plymotion.solver.report.section.codes import transform

FOLDER = Path(__file__).resolve().parents[1] / "reference/sections/vabs"
RESULTS = tomllib.loads((FOLDER / "results.toml").read_text(encoding="utf-8"))
CLASSICAL = [0, 3, 4, 5]


def cas1() -> str:
    """The input file of CAS1: six rows of cells through the wall, middles along the wall only."""
    rows = 6
    half = [(0.4465 + 0.005 * j, 0.235 + 0.005 * j) for j in range(rows + 1)]
    number: dict[tuple[float, float], int] = {}
    cells, orientation = [], []
    # corners of a wall by sign, number of cells along it, theta1, angles of its plies
    walls = [
        ((1, 1), (1, -1), 10, 270.0, (15, -15)),
        ((-1, 1), (1, 1), 15, 0.0, (-15, -15)),
        ((-1, -1), (-1, 1), 10, 90.0, (-15, 15)),
        ((1, -1), (-1, -1), 15, 180.0, (15, 15)),
    ]

    def node(first: Any, last: Any, j: int, s: float) -> int:
        place = (1 - s) * np.multiply(first, half[j]) + s * np.multiply(last, half[j])
        key = (round(float(place[0]), 9) + 0.0, round(float(place[1]), 9) + 0.0)
        return number.setdefault(key, len(number) + 1)

    for first, last, n, theta1, angles in walls:
        for i in range(n):
            for j in range(rows):
                s = [i / n, (i + 0.5) / n, (i + 1) / n]
                inner, outer = ([node(first, last, j + k, t) for t in s] for k in (0, 1))
                row = [inner[0], inner[2], outer[2], outer[0], inner[1], 0, outer[1], 0, 0]
                cells.append(row)
                orientation.append((angles[j % 2], theta1))
    lines = ["0 0", "1 0 0", "0 0 0 0", f"{len(number)} {len(cells)} 1"]
    lines += [f"{n} {x!r} {y!r}" for (x, y), n in number.items()]
    lines += [f"{i} {' '.join(map(str, row))}" for i, row in enumerate(cells, start=1)]
    lines += [
        f"{i} 1 {angle} {' '.join([repr(theta)] * 9)}"
        for i, (angle, theta) in enumerate(orientation, start=1)
    ]
    lines += ["1 1", "20.59e6 1.42e6 1.42e6", "0.87e6 0.87e6 0.696e6", "0.42 0.42 0.42", "1.0"]
    assert (len(number), len(cells)) == (700, 300)
    return "\n".join(lines) + "\n"


def three_cells() -> str:
    """The input file of a box of three cells, walls of eight-node quadrilaterals."""
    number: dict[tuple[float, float], int] = {}
    cells: list[list[int]] = []

    def node(place: Any) -> int:
        key = (round(float(place[0]), 6), round(float(place[1]), 6))
        return number.setdefault(key, len(number) + 1)

    def wall(outer: Any, inner: Any) -> None:
        """Two rows of cells between corners on two faces."""
        first, last = np.array(outer), np.array(inner)
        rows = [first + (last - first) * j / 2 for j in range(3)]
        for lower, upper in pairwise(rows):
            for i in range(len(lower) - 1):
                corners = np.array([lower[i], lower[i + 1], upper[i + 1], upper[i]])
                turn = np.cross(corners[1] - corners[0], corners[2] - corners[0])
                corners = corners if turn > 0.0 else corners[::-1]
                middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
                cells.append([node(place) for place in (*corners, *middles)])

    def line(first: Any, last: Any, n: int = 10) -> Any:
        return np.linspace(first, last, n + 1)

    for x, step in ((0.0, 0.1), (9.0, -0.1)):
        wall(line((x, 0), (x, 2)), line((x + step, 0.1), (x + step, 1.9)))
    for x in (2.0, 5.0):
        wall(line((x, 0.1), (x, 1.9)), line((x + 0.05, 0.1), (x + 0.05, 1.9)))
        for y, inner in ((2.0, 1.9), (0.0, 0.1)):
            wall(line((x, y), (x + 0.05, y), 2), line((x, inner), (x + 0.05, inner), 2))
    wall(line((0, 2), (2, 2)), line((0.1, 1.9), (2, 1.9)))
    for y, inner in ((2.0, 1.9), (0.0, 0.1)):
        wall(line((2.05, y), (5, y)), line((2.05, inner), (5, inner)))
        wall(line((5.05, y), (9, y)), line((5.05, inner), (8.9, inner)))
    face, back = RESULTS["three-cells"]["faces"]
    wall([(x, 0.0) for x in face], [(x, 0.1) for x in back])
    lines = ["0 0", "1 0 0", "0 0 0 0", f"{len(number)} {len(cells)} 1"]
    lines += [f"{n} {x:.6f} {y:.6f}" for (x, y), n in number.items()]
    lines += [f"{i} {' '.join(map(str, row))} 0" for i, row in enumerate(cells, start=1)]
    lines += [f"{i} 1 0 0.0 540.0 0 0 0 0 0 0 0" for i in range(1, len(cells) + 1)]
    lines += ["1 0", "0.26E+12 .300000000E+00", "1"]
    assert (len(number), len(cells)) == (862, 218)
    return "\n".join(lines) + "\n"


BOX = """1 1
0 0 0
0 0 0 0
8 4 2
1 .5 .5\n2 -.5 .5\n3 -.5 -.5\n4 .5 -.5\n5 .4 .4\n6 -.4 .4\n7 -.4 -.4\n8 .4 -.4
1 1 2 6 5 0 0 0 0 0\n2 2 3 7 6 0 0 0 0 0\n3 3 4 8 7 0 0 0 0 0\n4 4 1 5 8 0 0 0 0 0
1 1 0\n2 1 0\n3 1 0\n4 1 0
1 1 0
1 0\n1e9 .3\n1e3
2 0\n1e11 .25\n2.5e3
"""


def solved(text: str, folder: Path) -> Any:
    file = folder / "section.sg"
    file.write_text(text)
    return analyse(spec_of_another_code(file, folder), estimate=False)


@pytest.mark.one_end
@pytest.mark.provokes("no-density")
@pytest.mark.parametrize("name", ["laminate", "cas1", "i-section", "three-cells"])
def test_stiffness_and_mass(name: str, tmp_path: Path) -> None:
    made = {"cas1": cas1, "three-cells": three_cells}
    text = made[name]() if name in made else (FOLDER / f"{name}.sg").read_text()
    found, expected = solved(text, tmp_path), RESULTS[name]
    M = found.M
    if expected.get("mass_about_shear_centre"):
        M = transform(M, translation=tuple(found.shear_centre), kind="mass")
        assert "no-density" in [w["code"] for w in found.warnings]
    for ours, key in ((found.K, "K"), (M, "M")):
        theirs = np.array(expected[key])
        size = np.sqrt(np.outer(np.diag(theirs), np.diag(theirs)))
        assert np.abs((ours - theirs) / size).max() < expected["tolerance"]


def test_classical_stiffness_of_four_cells(tmp_path: Path) -> None:
    K = solved(BOX, tmp_path).K
    flexibility = np.linalg.inv(K)[np.ix_(CLASSICAL, CLASSICAL)]
    classical = np.diag(np.linalg.inv(flexibility))
    assert classical == pytest.approx(RESULTS["box"]["classical"], rel=RESULTS["box"]["tolerance"])
