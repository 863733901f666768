r"""The curved cantilever of MacNeal and Harder as a solid: the limit of shells beside beam theory.

.venv/bin/python benchmarks/shell_curved_beam_solid.py

Elements C3D20 of CalculiX, clamped at one end, an even shear stress on the other; see
shell_curved_beam.py for the sizes. Says so and ends where `ccx` is not installed.
"""

import os
import shutil
import subprocess
import tempfile
from collections import defaultdict
from itertools import product
from pathlib import Path

import numpy as np

EXACT = 0.08734, 0.5022  # beam theory: in plane, out of plane
INNER, WIDTH, THICKNESS = 4.12, 0.2, 0.1
E, NU = 1e7, 0.25
MESHES = [(12, 1, 1), (24, 2, 2), (48, 4, 2), (48, 4, 4)]
# corners and middles of sides of a C3D20 in steps of half an element
NODES = [
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1),
]  # fmt: skip


def displacements(n: tuple[int, int, int]) -> tuple[float, float]:
    """Mean displacement of the tip along both forces, over beam theory; n elements along, across
    and through the thickness."""
    number: dict[tuple[int, ...], int] = {}
    elements = []
    share: dict[tuple[int, ...], float] = defaultdict(float)
    for first in product(*(range(0, 2 * k, 2) for k in n)):
        places = [tuple(np.add(first, step).tolist()) for step in NODES]
        elements.append([number.setdefault(place, len(number) + 1) for place in places])
        for place in places:
            if place[0] == 2 * n[0]:  # an even stress on a face of eight nodes
                middle = place[1] % 2 + place[2] % 2
                share[place] += (1.0 / 3.0 if middle else -1.0 / 12.0) / (n[1] * n[2])
    lines = ["*NODE"]
    for (i, j, k), tag in number.items():
        angle, r = 0.25 * np.pi * i / n[0], INNER + 0.5 * WIDTH * j / n[1]
        z = THICKNESS * (0.5 * k / n[2] - 0.5)
        lines.append(f"{tag},{r * np.sin(angle):.12g},{r * np.cos(angle):.12g},{z:.12g}")
    lines.append("*ELEMENT,TYPE=C3D20,ELSET=ALL")
    for tag, nodes in enumerate(elements, start=1):
        row = [str(x) for x in (tag, *nodes)]
        lines += [",".join(row[:13]) + ",", ",".join(row[13:])]
    lines += ["*MATERIAL,NAME=M", "*ELASTIC", f"{E},{NU}", "*SOLID SECTION,ELSET=ALL,MATERIAL=M"]
    lines += ["*BOUNDARY", *(f"{tag},1,3" for place, tag in number.items() if place[0] == 0)]
    lines += ["*NSET,NSET=TIP", *(f"{number[place]}," for place in share)]
    for dof in (1, 3):
        lines += ["*STEP", "*STATIC", "*CLOAD,OP=NEW"]
        lines += [f"{number[place]},{dof},{part:.12g}" for place, part in share.items()]
        lines += ["*NODE PRINT,NSET=TIP", "U", "*END STEP"]
    found = _run("\n".join(lines) + "\n")
    means = [
        sum(part * case[number[place]][row] for place, part in share.items())
        for case, row in zip(found, (0, 2), strict=True)
    ]
    return means[0] / EXACT[0], means[1] / EXACT[1]


def _run(deck: str) -> list[dict[int, list[float]]]:
    """Displacements of the printed nodes in each step."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "ring.inp").write_text(deck)
        subprocess.run(
            ["ccx", "ring"], cwd=folder, check=True, capture_output=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        steps: list[dict[int, list[float]]] = []
        for line in (Path(folder) / "ring.dat").read_text().splitlines():
            if "displacements" in line:
                steps.append({})
            elif line.strip() and steps:
                words = line.split()
                steps[-1][int(words[0])] = [float(word) for word in words[1:4]]
    return steps


if __name__ == "__main__":
    if shutil.which("ccx") is None:
        print("ccx is not installed (apt-get install calculix-ccx)")
    else:
        for mesh in MESHES:
            inside, out = displacements(mesh)
            print(f"{mesh}: in plane {inside:.4f}, out of it {out:.4f}")
