"""What the commands make: modal packages of bodies, files of sections and of shells."""

import argparse
import dataclasses
import json
import math
import os
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ..solver.errors import InputError
from ..solver.package.common.container import has_fingerprint
from ..solver.package.common.plain_data import SpecError, by_mesh, check_form, mesh_key, share
from ..solver.package.specification import DesignTarget, fingerprint
from .batch import Made, Progress, build_all, reporter

# Environment variables that the common MPI launchers set.
LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS")


class AnalysedFiles:
    """Writes the results file of each specification.

    Parameters
    ----------
    options : of the command; those of the analysis are inputs like the specification itself
    team : processes that share the work on each file, of which rank 0 writes; None: no others
    progress : called with the name of each step of an analysis
    """

    def __init__(
        self, options: argparse.Namespace, team: Any = None, progress: Progress | None = None
    ) -> None:
        self.options, self.team, self.progress = options, team, progress

    def inputs(self, spec: Mapping[str, object]) -> Mapping[str, object]:
        """All inputs of a file, for its fingerprint."""
        raise NotImplementedError

    def analyse(self, spec: Mapping[str, object], **team: Any) -> Any:
        """Results of a specification; `team` has the processes that share the work, if any."""
        raise NotImplementedError

    def write(self, target: Path, result: Any) -> None:
        """Write the file."""
        raise NotImplementedError

    def unchanged(self, target: Path, spec: Mapping[str, object]) -> bool:
        """True if the target was made from the same inputs; the same on all ranks."""
        first = self.team is None or self.team.rank == 0
        same = first and has_fingerprint(target, fingerprint(self.inputs(spec)))
        return bool(same if self.team is None else self.team.broadcast(same))

    def make(self, spec: Mapping[str, object], target: Path) -> Made:
        """Analyse and write the file."""
        start = time.perf_counter()
        with self._together():
            result = self.analyse(spec, **({} if self.team is None else {"team": self.team}))
        with self._together():
            more = {"fingerprint": fingerprint(self.inputs(spec))}
            result = dataclasses.replace(result, provenance={**result.provenance, **more})
            if self.team is None or self.team.rank == 0:
                self.write(target, result)
        return self.summary(result, time.perf_counter() - start)

    def summary(self, result: Any, seconds: float) -> Made:
        """What was made in so many seconds, and its warnings."""
        return f"{result.provenance['dofs']} dofs", result.warnings

    @contextmanager
    def _together(self) -> Iterator[None]:
        """Work that ends on all ranks, or with the error of one on all of them."""
        failed: BaseException | None = None
        try:
            yield
        except Exception as error:
            if self.team is None:
                raise
            failed = error
        if self.team is not None:
            self.team.agree(failed)


class BodyPackages(AnalysedFiles):
    """Writes the modal package of each body; several processes share solids only."""

    def inputs(self, spec: Mapping[str, object]) -> Mapping[str, object]:
        """The specification."""
        return spec

    def analyse(self, spec: Mapping[str, object], **team: Any) -> Any:
        """Build the package; FEniCSx is loaded only if it is needed."""
        kind = spec.get("kind")
        if kind in ("imported", "solid") and spec.get("design"):
            raise SpecError(
                f"design: a body of kind {kind!r} has no derivatives by design parameters; "
                "expected a beam or a shell"
            )
        if self.team is not None and self.team.size > 1 and kind != "solid":
            raise SpecError(
                f"mpirun started {self.team.size} processes: expected one, as ranks share no body "
                f"of kind {kind or 'beam'!r}"
            )
        if kind == "imported":
            from .exchange.import_file import build_imported

            return build_imported(spec)
        from .body import build_body

        return build_body(spec, **team)

    def write(self, target: Path, result: Any) -> None:
        """Write the package, over a damaged one, too."""
        from ..solver.package.validation import write_valid

        write_valid(target, result, f"body {result.body}", own=True)

    def summary(self, result: Any, seconds: float) -> Made:
        """Times, unknowns, frequencies."""
        parts, dofs = result.provenance["seconds"], result.provenance["dofs"]
        hertz = result.frequencies / (2.0 * math.pi)
        span = f", {hertz[0]:.4g} to {hertz[-1]:.4g} Hz" if len(hertz) else ""
        first = next(iter(parts))  # "section" of a beam, "shell"
        return (
            f"{first} {parts[first]:.2f} s, modes {parts['modes']:.2f} s, "
            f"{dofs.get('section', dofs['body'])} dofs ({seconds:.2f} s in all; {result.n_mode} "
            f"modes{span})"
        ), result.provenance["warnings"]


class SectionFiles(AnalysedFiles):
    """Writes the section file of each specification."""

    def inputs(self, spec: Mapping[str, object]) -> dict[str, object]:
        """Specification, options and format."""
        from ..solver.package.section.section_schema import SECTION_FORMAT_VERSION

        given = {"estimate": not self.options.no_estimate, "accuracy": self.options.accuracy}
        if self.options.verify:
            given["verify"] = True
        return {"spec": spec, "options": given, "format": list(SECTION_FORMAT_VERSION)}

    def analyse(self, spec: Mapping[str, object], **team: Any) -> Any:
        """Analyse the section."""
        from .section.section_analysis import analyse  # loads FEniCSx

        return analyse(
            {key: value for key, value in spec.items() if key != "design"},
            "section",  # the same for all sections: it is part of the key of a cached mesh
            design=check_form(spec.get("design", {}), dict[str, list[DesignTarget]], "design"),
            estimate=not self.options.no_estimate,
            accuracy=self.options.accuracy,
            verify=self.options.verify,
            progress=self.progress,
            **team,
        )

    def write(self, target: Path, result: Any) -> None:
        """Write the section file."""
        from ..solver.package.section.section_file import write_section

        write_section(target, result)


class ShellFiles(AnalysedFiles):
    """Writes the results file of each shell."""

    def inputs(self, spec: Mapping[str, object]) -> dict[str, object]:
        """Specification, options and format."""
        from ..solver.package.shell.shell_schema import SHELL_FORMAT_VERSION

        given = {"options": {"verify": True}} if self.options.verify else {}
        return {"spec": spec, "format": list(SHELL_FORMAT_VERSION), **given}

    def analyse(self, spec: Mapping[str, object], **team: Any) -> Any:
        """Analyse the shell."""
        from .shell.analyses.shell_analysis import analyse  # loads FEniCSx

        return analyse(spec, "shell", verify=self.options.verify, progress=self.progress, **team)

    def write(self, target: Path, result: Any) -> None:
        """Write the shell file."""
        from ..solver.package.shell.shell_file import write_shell

        write_shell(target, result)


FILES: dict[str, type[AnalysedFiles]] = {
    "section": SectionFiles,
    "shell": ShellFiles,
}


def run(options: argparse.Namespace) -> int:
    """Make the files that a command asks for; returns the exit code."""
    files, team = FILES.get(options.command, BodyPackages), launched_ranks()
    listed = options.specs == [Path("-")]  # names follow on standard input

    def target_of(spec: Path) -> Path:
        name = (options.out_dir or spec.parent) / f"{spec.stem}.vtkhdf"
        return getattr(options, "out", None) or name

    # With names from standard input, each rank reports to the process that started it.
    with reporter(options.json, team is None or team.rank == 0 or listed) as (report, progress):
        product = files(options, team, progress)
        build = partial(build_all, product, target_of=target_of, force=options.force, report=report)
        if listed:
            names = (Path(line.rstrip("\n")) for line in sys.stdin)
            return max((build([name]) for name in names), default=0)
        specs = options.specs
        if files is SectionFiles:
            groups = by_mesh((path, _mesh_key(path)) for path in specs)
            specs = share([path for group in groups for path in group], options.shard)
        return build(specs)


def launched_ranks() -> Any:
    """The ranks of this job, or None; found without loading MPI where no launcher is at work."""
    if not any(name in os.environ for name in LAUNCHERS):
        return None
    from .fenicsx.team import Ranks

    ranks = Ranks()
    expected = os.environ.get("PLYMOTION_RANKS", "")
    if expected.isdecimal() and int(expected) != ranks.size:
        raise InputError(
            f"mpirun started {expected} processes, the MPI of this FEniCSx sees {ranks.size}: "
            f"expected the mpiexec of {sys.executable}"
        )
    return ranks


def _mesh_key(path: Path) -> str:
    """Text that is equal for equal meshes; an unreadable specification is a group of its own."""
    try:
        return mesh_key(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, AttributeError):
        return str(path)  # its error is reported when it is processed
