r"""The paper's box beam: 320 triangles of each element beside real CalculiX, and what follows.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" \
    benchmarks/shell_box_beam.py [--write docs/shells-accuracy.md]

CalculiX (S8R, 40 elements along the beam, 4 and 3 across the walls, one layer per ply) is run
here where `ccx` is installed; where it is not, its column is the stored one of
tests/reference/shells. --write puts the tables between the two lines with `box beam` of the file.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import argparse
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import shell_calculix
from samples.shell_benchmarks import expected, numbers
from shell_text import replace_between

ELEMENTS: dict[str, dict[str, Any]] = {
    "dst + cst": {"plate": "dst", "membrane": "cst", "drilling": "fictitious"},
    "dkmt + cst": {"membrane": "cst", "drilling": "fictitious"},
    "dst + opt": {"plate": "dst"},
    "dkmt + opt": {},
}
PAPER, FINE = (40, 1, 1), (100, 8, 4)  # 320 and 4800 triangles
ONE_WAY = {"diagonals": 0}  # of the cells; the paper does not say how it cut them
LAYUPS = {"0": "[0]6", "cus15": "CUS [15]6", "cas15": "CAS 15 (lay-up 3)"}
QUANTITIES = ("f1", "f2", "f3", "f4", "f5", "f6", "w/Fz", "v/Fy", "twist/T")
UNITS = ("Hz",) * 6 + ("m/N", "m/N", "rad/Nm")


def calculix(layup: str) -> tuple[np.ndarray, str]:
    """CalculiX's nine numbers, and where they come from."""
    if shutil.which("ccx") is None:
        return expected(f"ccx_box_{layup}"), "CalculiX (stored)"
    model = shell_calculix.box(layup, (40, 4, 3))
    answer = shell_calculix.run(model, n_mode=6)
    tip = shell_calculix.tip_numbers(model, answer)
    return np.array([*answer.frequencies[:6], *tip]), "CalculiX (run)"


def tables() -> list[str]:
    """Markdown of the three lay-ups and of the ratio that Fig. 8 shows."""
    lines: list[str] = []
    deflection: dict[str, dict[str, float]] = {}
    if shutil.which("ccx") is None:
        lines += [shell_calculix.ABSENT, ""]
    for layup, title in LAYUPS.items():
        name = f"ccx_box_{layup}"
        true, source = calculix(layup)
        found = {
            label: numbers(name, PAPER, elements=table, mesh=ONE_WAY)
            for label, table in ELEMENTS.items()
        }
        found["dkmt + opt, 4800"] = numbers(name, FINE)
        lines += [f"### {title}", "", "| | " + source + " | " + " | ".join(found) + " |"]
        lines.append("| --- |" + " --- |" * (len(found) + 1))
        for row, (quantity, unit) in enumerate(zip(QUANTITIES, UNITS, strict=True)):
            ratios = " | ".join(f"{values[row] / true[row]:.3f}" for values in found.values())
            lines.append(f"| {quantity} | {true[row]:.5g} {unit} | {ratios} |")
        lines.append("")
        columns = {source: true, **found}
        deflection[layup] = {label: float(values[6]) for label, values in columns.items()}
    lines += ["### What Fig. 8 of the paper would show: w of CAS 15 over w of [0]6", ""]
    labels = list(deflection["0"])
    lines += ["| diagonals | " + " | ".join(labels) + " |", "| --- |" + " --- |" * len(labels)]
    ratio = [deflection["cas15"][label] / deflection["0"][label] for label in labels]
    lines.append("| one way | " + " | ".join(f"{value:.2f}" for value in ratio) + " |")
    other = [
        numbers("ccx_box_cas15", PAPER, elements=table)[6]
        / numbers("ccx_box_0", PAPER, elements=table)[6]
        for table in ELEMENTS.values()
    ]
    lines.append("| alternating | | " + " | ".join(f"{value:.2f}" for value in other) + " | |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", type=Path, help="file to write into")
    options = parser.parse_args()
    lines = tables()
    if options.write:
        replace_between(options.write, "box beam", lines)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
