"""The commands `section` and `section-batch` of the preprocessor."""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...solver.package.shares import share
from ..batch import Outcome, build_all, tell_text
from ..json_lines import json_lines
from .batch import SectionFiles, launched_ranks
from .pool import build_over_ranks, mesh_groups

Tell = Callable[[Outcome, str], None]


def run_sections(options: argparse.Namespace, *, pool: bool) -> int:
    """Make the section files that the options ask for; returns the exit code.

    Parameters
    ----------
    pool : spread the sections over the ranks of an MPI job; else all ranks work on each section
    """
    ranks = None if pool else launched_ranks()
    first = ranks is None or ranks.rank == 0
    with _teller(options.json, first) as (tell, progress):
        product = SectionFiles(
            estimate=not options.no_estimate,
            accuracy=options.accuracy,
            ranks=ranks,
            progress=progress,
        )

        def target_of(spec: Path) -> Path:
            folder: Path = options.out_dir or spec.parent
            return folder / f"{spec.stem}.vtkhdf"

        if options.specs == [Path("-")]:
            return _answer(product, target_of, force=options.force, tell=tell)
        grouped = [path for group in mesh_groups(options.specs) for path in group]
        specs = share(grouped, options.shard)
        if pool and _world_size() > 1:
            product.progress = None  # the workers' words would come from another process
            return build_over_ranks(product, specs, target_of, force=options.force, tell=tell)
        return build_all(product, specs, target_of, force=options.force, tell=tell)


def _answer(
    product: SectionFiles, target_of: Callable[[Path], Path], *, force: bool, tell: Tell
) -> int:
    """Make one section after the other as their names come in on standard input."""
    code = 0
    for line in sys.stdin:
        path = Path(line.rstrip("\n"))
        code = max(code, build_all(product, [path], target_of, force=force, tell=tell))
    return code


def _world_size() -> int:
    from ..fenicsx import parallel

    return parallel.world_size()


@contextmanager
def _teller(as_json: bool, first: bool) -> Iterator[tuple[Tell, Callable[[str], None] | None]]:
    """Who tells of outcomes and of progress: the first rank, to people or to a program."""
    if not first:
        yield _nothing, None
    elif as_json:
        with json_lines() as lines:
            yield lines.tell, lines.progress
    else:
        yield tell_text, None


def _nothing(outcome: Outcome, place: str) -> None:
    """What the other ranks tell."""
