"""What the commands make: modal packages of bodies, files of sections and of shells."""

import argparse
import dataclasses
import json
import math
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from ..solver.errors import InputError
from ..solver.package.common.container import has_fingerprint
from ..solver.package.common.object_file import PACKED
from ..solver.package.common.plain_data import SpecError, by_mesh, check_form, mesh_key, share
from ..solver.package.specification import DesignTarget, fingerprint

# Process many specifications in one process, which shares imports, compiled forms and meshes.
#
# A `Product` (modal packages of bodies, section files) makes one file from one specification. This
# file has what all products share: reading, skipping files that are up to date, errors that do not
# stop the others, progress as lines for people or as one JSON object per line.

USER_ERROR = 2


class BatchError(Exception):
    """A specification that cannot be read."""


Made = tuple[str, Sequence[dict[str, str]]]  # a one-line summary, and the coded warnings


class Product(Protocol):
    """Makes one file from one specification."""

    def unchanged(self, target: Path, spec: Mapping[str, object]) -> bool:
        """True if the target is a valid file made from the same inputs."""

    def make(self, spec: Mapping[str, object], target: Path) -> Made:
        """Write the target."""


@dataclass(frozen=True)
class Outcome:
    """Result of one specification."""

    spec: str
    file: str
    status: str  # "built", "unchanged", "failed"
    seconds: float
    text: str = ""  # summary of a file that was built
    warnings: tuple[dict[str, str], ...] = ()  # {"code", "message"}
    error: str = ""  # in one line
    defect: str = ""  # traceback of an internal error


def _build(product: Product, path: Path, target: Path, *, force: bool = False) -> Outcome:
    """Make the file of one specification; an error becomes part of the outcome.

    Raises
    ------
    ImportError : FEniCSx is missing, so all other specifications would fail too.
    """
    start = time.perf_counter()

    def outcome(status: str, **more: Any) -> Outcome:
        seconds = time.perf_counter() - start
        return Outcome(str(path), str(target), status, seconds, **more)

    try:
        spec = _read(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        if not force and product.unchanged(target, spec):
            return outcome("unchanged")
        text, warnings = product.make(spec, target)
        return outcome("built", text=text, warnings=tuple(warnings))
    except ImportError:
        raise
    except Exception as error:
        # those with a message for the user are ours, and of the operating system
        own = type(error).__module__.startswith("plymotion.") or isinstance(error, OSError)
        defect = "" if own else traceback.format_exc()
        line = " ".join(str(error).split()) or type(error).__name__
        return outcome("failed", error=line, defect=defect)


def build_all(
    product: Product,
    specs: Sequence[Path],
    target_of: Callable[[Path], Path],
    *,
    force: bool = False,
    report: "Callable[[Outcome, str], None] | None" = None,
) -> int:
    """Make the file of every specification, one after the other; returns the exit code.

    Parameters
    ----------
    specs : JSON files
    target_of : the file that a specification becomes
    force : build also files that are up to date
    report : called with each outcome and its number ("3/14"); `print_outcome` by default
    """
    report = report or print_outcome
    code = 0
    for count, path in enumerate(specs, start=1):
        outcome = _build(product, path, target_of(path), force=force)
        report(outcome, f"{count}/{len(specs)}")
        if outcome.status == "failed":
            code = USER_ERROR
    return code


def print_outcome(outcome: Outcome, place: str) -> None:
    """Print one line of progress on stdout, and warnings and errors, one line each, on stderr."""
    name = Path(outcome.file).stem
    for warning in outcome.warnings:
        text = f"warning: {name}: {warning['code']}: {warning['message']}"
        print(text, file=sys.stderr, flush=True)
    if outcome.status != "failed":
        print(f"[{place}] {name}: {outcome.text or outcome.status}", flush=True)
        return
    if outcome.defect:
        print(outcome.defect, end="", file=sys.stderr)
        print("this is an error of the preprocessor, not of the input:", file=sys.stderr)
    print(f"error: {outcome.spec}: {outcome.error}", file=sys.stderr, flush=True)


def _read(path: Path) -> Mapping[str, object]:
    try:
        spec = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise BatchError("no such file") from error
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise BatchError(f"not JSON: {error}") from error
    if not isinstance(spec, dict):
        raise BatchError(f"expected a JSON object, found {type(spec).__name__}")
    return spec


Report = Callable[[Outcome, str], None]
Progress = Callable[[str], None]


@contextmanager
def reporter(as_json: bool, first: bool) -> Iterator[tuple[Report, Progress | None]]:
    """Reporter of outcomes and progress: only the first rank reports, as text or as JSON.

    Lines of JSON go to the original standard output, immediately and as a whole; output of
    libraries goes to standard error.
    """
    if not first:
        yield lambda _outcome, _place: None, None
        return
    if not as_json:
        yield print_outcome, None
        return
    sys.stdout.flush()
    lines = os.dup(1)
    os.dup2(2, 1)

    def write(content: dict[str, object]) -> None:
        os.write(lines, (json.dumps(content) + "\n").encode())

    try:
        yield (
            lambda outcome, _place: write(dataclasses.asdict(outcome)),
            lambda line: write({"progress": line}),
        )
    finally:
        sys.stdout.flush()
        os.dup2(lines, 1)
        os.close(lines)


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
        ending = PACKED if getattr(options, "packed", False) else ".vtkhdf"
        name = (options.out_dir or spec.parent) / f"{spec.stem}{ending}"
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
