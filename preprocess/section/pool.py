"""Sections of a batch, sorted by mesh and distributed over the workers of an MPI job."""

import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from pathlib import Path

from ...solver.package.common.shares import by_mesh, mesh_key
from ..batch import USER_ERROR, Outcome, build
from .batch import SectionFiles

CHUNKS = (
    4  # tasks per worker: enough for load balance, few enough to keep sections of one mesh together
)


def mesh_groups(specs: Sequence[Path]) -> list[list[Path]]:
    """Specification files grouped by equal meshes; an unreadable one is a group of its own."""
    return by_mesh((path, _mesh_key(path)) for path in specs)


def _mesh_key(path: Path) -> str:
    try:
        return mesh_key(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, AttributeError):
        return str(path)  # its error is reported when it is processed


def build_over_ranks(
    product: SectionFiles,
    specs: Sequence[Path],
    target_of: Callable[[Path], Path],
    *,
    force: bool,
    report: Callable[[Outcome, str], None],
) -> int:
    """Make all section files on the workers of the MPI job; returns the exit code.

    Only the first rank reports. Each worker keeps the data that sections of a mesh share.
    """
    from ..fenicsx import parallel

    code = 0
    workers = parallel.world_size() - 1
    largest = max(1, math.ceil(len(specs) / (CHUNKS * workers)))
    with parallel.pool() as executor:
        if executor is None:  # a worker that has received the signal to stop
            return code
        futures = [
            executor.submit(_build_some, product, [(path, target_of(path)) for path in part], force)
            for group in mesh_groups(specs)
            for part in _parts(group, largest)
        ]
        count = 0
        for future in as_completed(futures):
            for outcome in future.result():
                count += 1
                report(outcome, f"{count}/{len(specs)}")
                if outcome.status == "failed":
                    code = USER_ERROR
    return code


def _parts(group: list[Path], largest: int) -> list[list[Path]]:
    return [group[i : i + largest] for i in range(0, len(group), largest)]


def _build_some(
    product: SectionFiles, files: list[tuple[Path, Path]], force: bool
) -> list[Outcome]:
    """Task of a worker: a few sections of one mesh."""
    return [build(product, path, target, force=force) for path, target in files]
