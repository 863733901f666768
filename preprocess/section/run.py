"""The commands `section` and `section-batch` of the preprocessor."""

import argparse
from pathlib import Path

from ...solver.package.common.shares import share
from ..analysed_files import launched_ranks
from ..batch import build_all
from ..reporting import build_from_stdin, reporter
from .batch import SectionFiles
from .pool import build_over_ranks, mesh_groups


def run_sections(options: argparse.Namespace, *, pool: bool) -> int:
    """Make the requested section files; returns the exit code.

    Parameters
    ----------
    pool : distribute the sections over the ranks of an MPI job; else all ranks share each section
    """
    ranks = None if pool else launched_ranks()
    first = ranks is None or ranks.rank == 0
    with reporter(options.json, first) as (report, progress):
        product = SectionFiles(
            estimate=not options.no_estimate,
            accuracy=options.accuracy,
            verify=options.verify,
            ranks=ranks,
            progress=progress,
        )

        def target_of(spec: Path) -> Path:
            folder: Path = options.out_dir or spec.parent
            return folder / f"{spec.stem}.vtkhdf"

        if options.specs == [Path("-")]:
            return build_from_stdin(product, target_of, force=options.force, report=report)
        grouped = [path for group in mesh_groups(options.specs) for path in group]
        specs = share(grouped, options.shard)
        if pool and _world_size() > 1:
            product.progress = None  # progress of workers would come from another process
            return build_over_ranks(product, specs, target_of, force=options.force, report=report)
        return build_all(product, specs, target_of, force=options.force, report=report)


def _world_size() -> int:
    from ..fenicsx import parallel

    return parallel.world_size()
