"""One run: packages, model, consistent start, integration, results."""

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..checks.finished import FinishedRun, Look
from ..errors import InputError, PackageError
from ..inputs.case.record import sealed
from ..integrators.choice import make_integrator
from ..integrators.generic import Steps, StopRequest, Watch, integrate
from ..math.arrays import Array
from ..package import ModalPackage, read_package
from ..results import RunResult, write_result, write_summary
from .inputs_digest import inputs_sha256
from .outcome import RunSpec, collect
from .preparation import Prepared, prepare
from .timing import Stopwatch

if TYPE_CHECKING:
    from ..inputs.case.schema import Mechanism

INCOMPLETE = 3  # exit code of a run that ended early with a result


def read_run(file: Path) -> RunSpec:
    """Read build/<case>/runs/<run>.json and the packages that it names.

    Raises
    ------
    InputError, PackageError
        Not a run file; a package that cannot be read or was built from other inputs.
    """
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
        case, run = table["case"], table["run"]
        mechanism = _mechanism(table, str(file))
        entries = table["packages"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{file}: not a run file ({error}); expected one written by "
            "`python -m plymotion.solver check`"
        ) from error
    packages = {}
    for body, entry in entries.items():
        path = file.parent.parent / entry["file"]
        whose = f"bodies.{body} of case {case}, run {run}"
        packages[body] = package_of(path, entry.get("inputs_sha256"), whose, f"make {case}")
    return RunSpec(case, run, mechanism, packages)


def _mechanism(table: dict[str, Any], where: str) -> "Mechanism":
    """Return the mechanism of a run file; one that was edited is checked."""
    found = sealed(table["mechanism"], table.get("checked"))
    if found is None:
        from ..inputs.case.resolved import resolved  # takes 0.2 s

        found = resolved(table["mechanism"], where)
    return found


def package_of(path: Path, expected: str | None, whose: str, remedy: str) -> ModalPackage:
    """Read the package that a run file names.

    Parameters
    ----------
    expected : hash of the inputs that it must have been built from; None: any
    whose, remedy : body and command, for messages

    Raises
    ------
    PackageError
        It cannot be read, or was built from other inputs.
    """
    path = path.resolve()
    shown = path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
    package = read_package(shown)
    found = package.provenance.get("inputs_sha256")
    if expected is not None and found != expected:
        raise PackageError(
            f"{shown}: built from other inputs than {whose} "
            f"(inputs {str(found)[:12]}, expected {expected[:12]}): run `{remedy}`"
        )
    return package


def output_times(t_end: float, step: float) -> Array:
    """Return 0, step, 2 step, ..., t_end, (k,) [s]; the last interval may be shorter."""
    count = int(np.floor(t_end / step * (1 + 1e-12)))
    times = np.linspace(0.0, count * step, count + 1)
    if t_end - times[-1] > 1e-9 * t_end:
        times = np.append(times, t_end)
    times[-1] = t_end
    return times


def integrated(
    prepared: Prepared, watch: Watch | None = None, look: Look | None = None
) -> FinishedRun:
    """Integrate a prepared mechanism from its start to `t_end`: a single run, or one of a sweep.

    Numerical trouble and Ctrl-C while it steps are no exceptions but the status of the solution.

    Parameters
    ----------
    watch : sees the steps in place of the monitors, which it must call itself
    look : at how many output times the checks look
    """
    solver = prepared.mechanism.solver
    solution, order = prepared.refused, 0
    if solution is None:
        integrator = make_integrator(
            prepared.model,
            prepared.y0,
            solver,
            prepared.treatment,
            functions=prepared.functions,
        )
        times = output_times(solver.t_end, solver.output_step)
        solution = integrate(integrator, times, watch=watch or prepared.watch)
        order = integrator.order
    return prepared.finished(prepared.explained(solution), order, look or Look())


class _Progress:
    """Show simulated time and pass the steps on to the monitors."""

    def __init__(self, watch: Watch, t_end: float, label: str, show: bool) -> None:
        self.watch, self.note = watch, watch.note
        self.seconds = 0.0  # CPU time of the monitors
        self.bar: Any = None
        if show and sys.stderr.isatty():
            from tqdm import tqdm  # here: without a terminal nothing is drawn

            self.bar = tqdm(
                total=t_end,
                desc=label,
                unit="s",
                bar_format="{desc}: {percentage:3.0f}% |{bar}| {n:.3f}/{total:.3f} s [{elapsed}]",
                leave=False,
                mininterval=0.2,
            )

    def __call__(self, steps: Steps) -> StopRequest | None:
        if self.bar is not None:
            self.bar.update(steps.t[-1] - self.bar.n)
        begin = time.process_time()
        try:
            return self.watch(steps)
        finally:
            self.seconds += time.process_time() - begin

    def close(self) -> None:
        """Remove the bar."""
        if self.bar is not None:
            self.bar.close()


def execute(
    spec: RunSpec, *, progress: bool = True, allow_python: bool = False
) -> tuple[RunResult, dict[str, Any]]:
    """Integrate one run; return the result and the summary.

    Raises
    ------
    InputError
        A mechanism that cannot be assembled, contradictory constraints, an integrator that
        does not go with the treatment of constraints.
    """
    begin, clock = time.perf_counter(), Stopwatch()
    prepared = prepare(spec.mechanism, spec.packages, allow_python=allow_python)
    clock.lap("build")
    follow = _Progress(prepared.watch, spec.mechanism.solver.t_end, spec.run, progress)
    try:
        finished = integrated(prepared, follow)
    finally:
        follow.close()
    solve_s = time.perf_counter() - begin
    clock.lap("integrate")
    clock.move(follow.seconds, "integrate", "monitors")
    result, summary = collect(spec, prepared.measured, finished, solve_s)
    clock.lap("recover")
    summary["cost"]["seconds"] = clock.seconds
    return result, summary


def run_file(
    file: Path,
    out: Path,
    *,
    progress: bool = True,
    import_s: float = 0.0,
    allow_python: bool = False,
) -> dict[str, Any]:
    """Execute a run file and write result.vtkhdf and summary.json into `out`.

    `import_s` is the CPU time that the program had taken before, for the summary. `allow_python`:
    functions of the user may run.
    """
    clock, digest = Stopwatch(), inputs_sha256(file)
    spec = read_run(file)
    clock.lap("load")
    result, summary = execute(spec, progress=progress, allow_python=allow_python)
    clock.skip()
    out.mkdir(parents=True, exist_ok=True)
    write_result(out / "result.vtkhdf", result)
    clock.lap("write")
    seconds = summary["cost"]["seconds"]
    seconds["import"] = import_s
    seconds["load"] += clock.seconds["load"]
    seconds["write"] = clock.seconds["write"]
    summary["inputs_sha256"] = digest
    # Last, because make takes it as the sign of a finished run.
    write_summary(out / "summary.json", summary)
    return summary
