"""The isotropic obstacle course: every element over its mesh, as displacement over reference.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/shell_course.py JSON

Problems and references are those of tests/reference/shells/benchmarks.toml; shell_chart.py draws
the numbers.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import json
import sys
from pathlib import Path
from typing import Any

from samples.shell_benchmarks import expected, numbers

from plymotion.preprocess import fenicsx

ELEMENTS: dict[str, dict[str, Any]] = {
    "dkmt + opt": {},
    "dst + opt": {"plate": "dst"},
    "dkt + opt": {"plate": "dkt"},
    "mitc3 + opt": {"plate": "mitc3"},
    "dkmt + allman": {"membrane": "allman"},
    "dkmt + cst, tie": {"membrane": "cst"},
    "dst + cst, fictitious": {"plate": "dst", "membrane": "cst", "drilling": "fictitious"},
}
SQUARES, STRIPS = (4, 8, 16, 32, 64), (1, 2, 4, 8)
PROBLEMS: dict[str, tuple[str, list[Any]]] = {
    "Scordelis-Lo roof": ("scordelis", [*SQUARES]),
    "pinched cylinder": ("pinched_cyl", [*SQUARES]),
    "hemisphere, 18° hole": ("hemisphere18", [*SQUARES]),
    "twisted beam, load along z": ("twisted_z", [(6 * k, k) for k in STRIPS]),
    "twisted beam, load along y": ("twisted_y", [(6 * k, k) for k in STRIPS]),
    "curved beam, in plane": ("curved_in", [(12 * k, k) for k in STRIPS]),
    "straight beam, in plane": ("straight_in", [(6 * k, k) for k in STRIPS]),
    "straight beam, out of plane": ("straight_out", [(6 * k, k) for k in STRIPS]),
}


def main(target: Path) -> None:
    curves = []
    for problem, (name, meshes) in PROBLEMS.items():
        for elements, table in ELEMENTS.items():
            ratios = [
                float(numbers(name, n, elements=table)[0] / expected(name)[0]) for n in meshes
            ]
            print(f"{problem:28s} {elements:22s}", " ".join(f"{r:7.3f}" for r in ratios))
            cells = [n if isinstance(n, int) else n[1] for n in meshes]
            curves.append(
                {"problem": problem, "elements": elements, "cells": cells, "ratios": ratios}
            )
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps({"versions": fenicsx.versions(), "curves": curves}, indent=1))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
