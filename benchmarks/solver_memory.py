"""Peak memory and processor time of long runs by `plymotion run`."""

import tempfile
from pathlib import Path
from typing import Any

from processes import cost
from solver_methods import DEFAULT
from solver_problems import EIGHT, Problem, chain, double_pendulum

RTOL = 1e-4
OUTPUT_STEP = 0.01  # [s] of the chain


def measure(links: int) -> list[dict[str, Any]]:
    """One row per run."""
    return [
        _row("double pendulum, 1 s, outputs every 0.001 s", double_pendulum()),
        _row("double pendulum, 60 s, outputs every 0.001 s", double_pendulum(t_end=60.0)),
        _row(f"chain of {links} links, 0.05 s", chain(links, 0.05, EIGHT / "hand.vtkhdf")),
    ]


def _row(title: str, problem: Problem) -> dict[str, Any]:
    file = problem.written(f"memory-{problem.name}", problem.solver(DEFAULT, RTOL))
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        used = cost(["-m", "plymotion", "run", str(file), "--out", str(out), "--quiet"])
        size = (out / "result.vtkhdf").stat().st_size
    return {"run": title, "peak_mb": used.peak_mb, "cpu_s": used.cpu_s, "file_mb": size / 2**20}
