"""Section files made by a batch, in one process or on the workers of an MPI job."""

import argparse
import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

from ....solver.package.common.shares import by_mesh, mesh_key, share
from ....solver.package.fingerprint import fingerprint
from ....solver.package.section.io import write_section
from ....solver.package.section.schema import SECTION_FORMAT_VERSION, SectionFile
from ...analysed_files import AnalysedFiles, Ranks, launched_ranks
from ...batch import USER_ERROR, Outcome, build, build_all
from ...reporting import build_from_stdin, reporter


class SectionFiles(AnalysedFiles[SectionFile]):
    """Writes the section file of each specification.

    Parameters
    ----------
    estimate, accuracy, verify : of `analyse`; they are inputs like the specification itself
    ranks, progress : see `AnalysedFiles`
    """

    def __init__(
        self,
        *,
        estimate: bool = True,
        accuracy: float | None = None,
        verify: bool = False,
        ranks: Ranks | None = None,
        progress: Callable[[str], None] | None = None,
    ) -> None:
        super().__init__(ranks, progress)
        self.estimate = estimate
        self.accuracy = accuracy
        self.verify = verify

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all inputs of a section file."""
        options = {"estimate": self.estimate, "accuracy": self.accuracy}
        if self.verify:
            options["verify"] = True
        version = list(SECTION_FORMAT_VERSION)
        return fingerprint({"spec": spec, "options": options, "format": version})

    def analyse(self, spec: dict[str, Any], **team: Any) -> SectionFile:
        """Analyse the section."""
        from .analysis import analyse  # here: FEniCSx is loaded only where something is built

        return analyse(
            spec,
            "section",  # the same for all sections: it is part of the key of a cached mesh
            estimate=self.estimate,
            accuracy=self.accuracy,
            verify=self.verify,
            progress=self.progress,
            **team,
        )

    def write(self, target: Path, result: SectionFile) -> None:
        """Write the section file."""
        write_section(target, result)


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
    from ...fenicsx import parallel

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


def run_sections(options: argparse.Namespace, *, pool: bool) -> int:
    """Make the requested section files; returns the exit code.

    Parameters
    ----------
    pool : distribute the sections over the ranks of an MPI job; else all ranks share each section
    """
    ranks = None if pool else launched_ranks()
    # With names from standard input, each rank reports to the process that started it.
    first = ranks is None or ranks.rank == 0 or options.specs == [Path("-")]
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
    from ...fenicsx import parallel

    return parallel.world_size()
