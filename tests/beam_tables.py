"""A beam of a table of stations: curved, twisted, tapered, with couplings of all kinds."""

from pathlib import Path

import numpy as np
from beam_samples import coupled_stiffness

from plymotion.preprocess.beam.section_mass import SectionMass
from plymotion.solver.inputs.case.beam_table import COLUMNS, PLACES, TRAPEZE, TWIST, UPPER

AT = np.array([0.0, 0.15, 0.4, 0.7, 1.0])
STIFFNESS = coupled_stiffness(np.diag([4e3, 1e3, 1.2e3, 20.0, 30.0, 25.0]))
MASS = SectionMass(1.0, np.array([0.0, 0.02, -0.01]), np.diag([0.03, 0.018, 0.012])).matrix()
SHARE = 1.0 - 0.7 * AT  # of K and M at the root
POINTS = np.column_stack([1.5 * AT, 0.1 * AT**2, -0.2 * AT**2])
ANGLES = -40.0 * (1.0 - AT)  # [deg]


def columns() -> dict[str, list[float]]:
    found = dict(zip(PLACES, POINTS.T.tolist(), strict=True))
    found[TWIST] = ANGLES.tolist()
    for letter, matrix in (("K", STIFFNESS), ("M", MASS)):
        for i, j in UPPER:
            found[f"{letter}{i + 1}{j + 1}"] = (SHARE * matrix[i, j]).tolist()
    return {name: found[name] for name in COLUMNS} | {a: [0.01] * len(AT) for a in TRAPEZE}


def write_table(file: Path, table: dict[str, list[float]] | None = None) -> Path:
    found = table or columns()
    rows = zip(*found.values(), strict=True)
    lines = ["# a remark", ",".join(found), *(",".join(map(repr, row)) for row in rows)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file
