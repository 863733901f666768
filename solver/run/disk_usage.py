"""Room on the disk that a run will take."""

import os
import shutil
from pathlib import Path

from ..results.nodes import MOST_STORED
from .outcome import RunSpec

WORTH_A_NOTE = 1_000_000_000  # bytes
RIGID_BODY, PER_BODY = 3, 14  # drawn points; numbers of position and velocity
CONSTRAINTS, OTHERS = 6, 8  # numbers of a joint; of time, energies, violations


def nearest_folder(folder: Path) -> Path:
    """Return a folder, or the one above it that exists."""
    whole = Path(os.path.realpath(folder))  # Path.resolve raises where links form a loop
    return next(each for each in (whole, *whole.parents) if each.is_dir())


def disk_note(spec: RunSpec, folder: Path) -> str:
    """Return a remark on a run whose results, on the disk of `folder`, are large; "" for others."""
    mechanism = spec.mechanism
    times = mechanism.solver.t_end / mechanism.solver.output_step
    bodies = len(mechanism.bodies)
    states = PER_BODY * bodies + 2 * sum(p.n_mode for p in spec.packages.values())
    points = sum(len(p.nodes_B) for p in spec.packages.values())
    points += RIGID_BODY * (bodies - len(spec.packages))
    drawn = 8.0 * times * 3 * points
    if mechanism.solver.node_positions == "auto" and drawn > MOST_STORED:
        drawn = 0.0
    others = CONSTRAINTS * len(mechanism.joints) + OTHERS + len(mechanism.signals)
    results = 8.0 * times * (states + others) + drawn
    passing = 8.0 * times * (states + others)
    if results < WORTH_A_NOTE:
        return ""
    free = shutil.disk_usage(folder).free
    return (
        f"{times:.3g} output times need up to {_size(results)} in result.vtkhdf, and "
        f"{_size(passing)} while the run lasts ({_size(free)} are free): a larger "
        "solver.output_step needs less"
    )


def _size(count: float) -> str:
    return f"{count / 1e9:.1f} GB"
