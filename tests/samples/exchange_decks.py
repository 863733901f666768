"""The arm 500 x 40 x 10 mm of carbon/epoxy [0/45] as decks of CalculiX and MYSTRAN."""

from collections.abc import Iterable
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from plymotion.solver.math.arrays import Array

LENGTH, WIDTH, PLY = 0.5, 0.04, 0.005  # [m], two plies
ANGLES = (0.0, 45.0)  # from the bottom
E1, E2, G12, G23, NU12, NU23, RHO = 142e9, 9.79e9, 6.0e9, 3.447e9, 0.3, 0.42, 1550.0
MASS = RHO * LENGTH * WIDTH * 2 * PLY


class Unit(NamedTuple):
    """Numbers of a deck per SI value."""

    length: float
    stress: float
    density: float


SI, MM = Unit(1.0, 1.0, 1.0), Unit(1e3, 1e-6, 1e-12)  # mm, t, s: MPa, t/mm3


def write_solid(
    file: Path,
    count: tuple[int, int],
    unit: Unit = SI,
    steps: str = "",
    box: tuple[float, float, float] = (LENGTH, WIDTH, 2 * PLY),
) -> Path:
    """Deck of C3D20R, one element per ply through the thickness; sets NROOT and NTIP."""
    nx, ny = count
    fine = (2 * nx, 2 * ny, 4)
    size = np.array(box)
    label: dict[tuple[int, int, int], int] = {}
    lines = ["*NODE, NSET=NALL"]
    for at in product(*(range(n + 1) for n in fine)):
        if sum(k % 2 for k in at) > 1:
            continue  # no node in faces and inside
        label[at] = len(label) + 1
        point = (np.array(at) / fine - [0.0, 0.5, 0.5]) * size * unit.length
        lines.append(f"{label[at]}, " + ", ".join(f"{x:.12g}" for x in point))
    corners = [(0, 0), (2, 0), (2, 2), (0, 2)]
    sides = [(1, 0), (2, 1), (1, 2), (0, 1)]
    ring = [*((*c, 0) for c in corners), *((*c, 2) for c in corners)]
    ring += [*((*c, 0) for c in sides), *((*c, 2) for c in sides), *((*c, 1) for c in corners)]
    number = 0
    for ply in range(2):
        lines.append(f"*ELEMENT, TYPE=C3D20R, ELSET=PLY{ply}")
        for i, j in product(range(nx), range(ny)):
            number += 1
            nodes = [label[2 * i + a, 2 * j + b, 2 * ply + c] for a, b, c in ring]
            lines.append(f"{number}, " + ", ".join(map(str, nodes[:15])) + ",")
            lines.append(", ".join(map(str, nodes[15:])))
    lines += set_of("NROOT", (n for at, n in label.items() if at[0] == 0))
    lines += set_of("NTIP", (n for at, n in label.items() if at[0] == fine[0]))
    lines += material(unit)
    for ply, angle in enumerate(ANGLES):
        c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
        lines += [f"*ORIENTATION, NAME=O{ply}", f"{c:.16g}, {s:.16g}, 0, {-s:.16g}, {c:.16g}, 0"]
        lines.append(f"*SOLID SECTION, ELSET=PLY{ply}, MATERIAL=CFRP, ORIENTATION=O{ply}")
    file.write_text("\n".join([*lines, steps or STORED]) + "\n")
    return file


STORED = "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n2\n*END STEP"


def set_of(name: str, labels: Iterable[int]) -> list[str]:
    """A set of nodes, eight to a line."""
    every = sorted(labels)
    rows = [every[i : i + 8] for i in range(0, len(every), 8)]
    return [f"*NSET, NSET={name}", *(", ".join(map(str, row)) for row in rows)]


def material(unit: Unit) -> list[str]:
    """Engineering constants and density."""
    s = unit.stress
    moduli = [E1, E2, E2, NU12, NU12, NU23, G12, G12]
    values = [v if v in (NU12, NU23) else v * s for v in moduli]
    return [
        "*MATERIAL, NAME=CFRP",
        "*ELASTIC, TYPE=ENGINEERING CONSTANTS",
        ", ".join(f"{v:.12g}" for v in values) + ",",
        f"{G23 * s:.12g}",
        "*DENSITY",
        f"{RHO * unit.density:.12g}",
    ]


def frequencies(dat: Path) -> Array:
    """Circular frequencies of a .dat file of CalculiX, real parts."""
    text = dat.read_text().split("E I G E N V A L U E   O U T P U T")[1]
    rows = []
    for line in text.splitlines():
        words = line.split()
        if len(words) >= 4 and words[0].isdecimal():
            rows.append(float(words[2]))
        elif rows:
            break
    return np.array(rows)


def write_mystran(file: Path, count: tuple[int, int]) -> Path:
    """Bulk data of CQUAD4 with PCOMP at mid-height; OUTPUT4 of KGG and MGG.

    MYSTRAN 18 leaves out the mass of one ply of its first PCOMP element: four CONM2 add it.
    """
    nx, ny = count
    lines = ["ID ARM,FREE", "SOL 3", "OUTPUT4 KGG,MGG,,,//-1/21 $", "CEND", "METHOD = 1"]
    lines += ["BEGIN BULK", "EIGRL,1,,,12", "PARAM,SOLLIB,BANDED"]

    def label(i: int, j: int) -> int:
        return 1 + i * (ny + 1) + j

    for i, j in product(range(nx + 1), range(ny + 1)):
        x, y = LENGTH * i / nx, WIDTH * (j / ny - 0.5)
        lines.append(f"GRID    {label(i, j):8d}        {x:8.5f}{y:8.5f}{0.0:8.5f}")
    for n, (i, j) in enumerate(product(range(nx), range(ny)), 1):
        ring = [label(i, j), label(i + 1, j), label(i + 1, j + 1), label(i, j + 1)]
        lines.append(f"CQUAD4  {n:8d}{1:8d}" + "".join(f"{k:8d}" for k in ring))
    lost = RHO * PLY * LENGTH / nx * WIDTH / ny
    corners = [label(0, 0), label(1, 0), label(1, 1), label(0, 1)]
    lines += [f"CONM2,{10**6 + k},{k},,{lost / 4:.9g}" for k in corners]
    plies = ",".join(f"1,{PLY},{angle},YES" for angle in ANGLES)
    lines += ["PCOMP,1,,,,,,,,+P", f"+P,{plies}"]
    lines.append("MAT8,1," + ",".join(f"{v:.3E}" for v in (E1, E2, NU12, G12, G12, G23, RHO)))
    file.write_text("\n".join([*lines, "ENDDATA"]) + "\n")
    return file


def write_shell(file: Path, count: tuple[int, int], modes: int) -> Path:
    """Deck of S8R with a composite section, root edge held; natural modes at the deck's nodes."""
    nx, ny = count
    label: dict[tuple[int, int], int] = {}
    lines = ["*NODE, NSET=NALL"]
    for i, j in product(range(2 * nx + 1), range(2 * ny + 1)):
        if i % 2 and j % 2:
            continue
        label[i, j] = len(label) + 1
        x, y = LENGTH * i / (2 * nx), WIDTH * (j / (2 * ny) - 0.5)
        lines.append(f"{label[i, j]}, {x:.12g}, {y:.12g}, 0.0")
    lines.append("*ELEMENT, TYPE=S8R, ELSET=ARM")
    ring = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    for n, (i, j) in enumerate(product(range(nx), range(ny)), 1):
        nodes = [label[2 * i + a, 2 * j + b] for a, b in ring]
        lines.append(f"{n}, " + ", ".join(map(str, nodes)))
    lines += set_of("NROOT", (n for at, n in label.items() if at[0] == 0))
    lines += set_of("NTIP", (n for at, n in label.items() if at[0] == 2 * nx))
    lines += material(SI)
    for ply, angle in enumerate(ANGLES):
        c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
        lines += [f"*ORIENTATION, NAME=O{ply}", f"{c:.16g}, {s:.16g}, 0, {-s:.16g}, {c:.16g}, 0"]
    lines.append("*SHELL SECTION, ELSET=ARM, COMPOSITE")
    lines += [f"{PLY}, , CFRP, O{ply}" for ply in range(len(ANGLES))]
    lines += ["*BOUNDARY", "NROOT, 1, 6", "*STEP", "*FREQUENCY", str(modes)]
    lines += ["*NODE FILE, OUTPUT=2D", "U", "*END STEP"]
    file.write_text("\n".join(lines) + "\n")
    return file
