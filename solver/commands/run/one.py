"""One run file, with `[fidelity]` or without: what commands and the Python interface call."""

from functools import partial
from pathlib import Path
from typing import Any

from ...results import RunResult
from ...run.execution import run_file
from ...run.outcome import RunSpec


def run_one(
    file: Path,
    out: Path,
    *,
    progress: bool = True,
    import_s: float = 0.0,
    allow_python: bool = False,
    allow_doubtful: bool = False,
) -> dict[str, Any]:
    """Execute a run file; return its summary. See `run_file`."""
    return run_file(
        file,
        out,
        progress=progress,
        import_s=import_s,
        allow_python=allow_python,
        allow_doubtful=allow_doubtful,
        planned=partial(_planned, file, allow_doubtful),
    )


def _planned(
    file: Path, allow_doubtful: bool, spec: RunSpec, digest: str
) -> tuple[RunResult, dict[str, Any]]:
    """Execute a run with `[fidelity]`."""
    from ...fidelity.delivery.execution import delivered  # most runs need no planner

    return delivered(file, spec, digest, allow_doubtful=allow_doubtful)
