"""Compare a run of cases/slider-crank with closed forms: smoke.py SUMMARY.json."""

import json
import math
import sys
from pathlib import Path
from typing import Any

RUN_UP, SPEED = 0.02, 150.0  # of the drive: seconds, rad/s
CRANK, ROD = 0.15, 0.3  # [m]


def problems(summary: dict[str, Any]) -> list[str]:
    """Return what is wrong with the run; a bent rod is no shorter, so the rigid motion holds."""
    found = [f"{w['code']}: {w['message']}" for w in summary["warnings"]]
    if not summary["completed"]:
        found.append(f"ended early: {summary['message']}")
    angle = SPEED * (summary["t_end"] - 0.5 * RUN_UP)
    slider = CRANK * math.cos(angle) + math.sqrt(ROD**2 - (CRANK * math.sin(angle)) ** 2)
    for name, expected in (("crank_angle", angle), ("slider_x", slider)):
        value = summary["signals"][name]["final"]
        if abs(value - expected) > 1e-5:
            found.append(f"{name} at the end: expected {expected:.9g}, found {value:.9g}")
    return found


def main(file: str) -> int:
    """Print what is wrong, or that nothing is; the exit code."""
    found = problems(json.loads(Path(file).read_text(encoding="utf-8")))
    print("\n".join(found) or f"smoke: {file}: the motion is that of the closed form")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
