"""Derivatives of sections and bodies by designs, against rebuilt ones, and what they cost.

python benchmarks/design_derivatives.py build/benchmarks/design-derivatives.json
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

from fe.test_design_bodies import LAYUP, beam, entry, skewed, square, worst
from fe.test_section_derivatives import (
    ANGLES,
    OTHERS,
    PRISMATIC,
    Design,
    analyse,
    differences,
    quotients,
)

from plymotion.preprocess.shell.body import shell_body

AGAIN = 5
SECTIONS = {"box, 12 angles": (PRISMATIC, ANGLES, 10.0), **OTHERS}
BODIES = {
    "beam, modes in clusters": (beam(square(), 7, design={"a": entry(4, 5)}), 3.0),
    "shell": (skewed(design=LAYUP), 5.0),
    "shell, second order": (
        skewed(design=LAYUP, reference={"kind": "chord", "at": ["root", "tip"]}, second_order=True),
        5.0,
    ),
}


def of_section(spec: dict[str, Any], design: Design, steps: float) -> dict[str, float]:
    """Errors of K and M by sqrt(K_ii K_jj), and of strains by the largest."""
    section = analyse(spec, estimate=False, design=design)
    found = differences(section, quotients(spec, design, steps))
    return {path: float(found[path]) for path in ("K", "M", "recovery/strain_M")}


def least(**asked: Any) -> float:
    """Processor time of an analysis [s], the least of some."""
    seconds = []
    for _ in range(AGAIN):
        begin = time.process_time()
        analyse(PRISMATIC, **asked)
        seconds.append(time.process_time() - begin)
    return min(seconds)


def main() -> None:
    """Compute all and write the file that the command line names."""
    shell_body.rounded = lambda values: values  # differences need all digits
    alone = least(estimate=False)
    of_K = least(estimate=False, design=ANGLES, design_strains=False)
    found: dict[str, Any] = {
        "sections": {name: of_section(*given) for name, given in SECTIONS.items()},
        "bodies": {name: max(worst(*given).values()) for name, given in BODIES.items()},
        "analyses_for_12_angles": (least(estimate=False, design=ANGLES) - alone) / alone,
        "analyses_for_12_angles_without_strains": (of_K - alone) / alone,
        "analyses_for_an_estimate": (least() - alone) / alone,
    }
    text = json.dumps(found, indent=1)
    print(text)
    Path(sys.argv[1]).write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
