"""`plymotion.run`: a run of a case, computed as the command `plymotion CASE.toml` does."""

from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path

from ..solver.errors import InputError, few, nearest
from ..solver.inputs.case.write import write_case
from ..solver.package.common.replaceable import named_by_user
from ..solver.run.inputs_digest import up_to_date
from ..solver.studies.cases import turn
from ..solver.studies.runs import run_one
from ..solver.studies.screen import shown
from ..solver.workers.launch import keep_preprocessors
from ..solver.workers.packages import build_needed
from .case import Case, as_case
from .result import Result


def run(
    case: Case | str | Path,
    run: str | None = None,
    *,
    out: str | Path | None = None,
    packages: str | Path | None = None,
    coarse: bool = False,
    force: bool = False,
    progress: bool = False,
    allow_python: bool = False,
) -> Result:
    """Compute a run of a case, or read it if it is up to date; the numbers are those of
    `plymotion CASE.toml`.

    Packages of flexible bodies are built where they are missing or out of date, which needs
    FEniCSx.

    Parameters
    ----------
    case : a case, or its file
    run : name of the run; absent: the only one
    out : folder of the case; absent: build/NAME, as of the command
    packages : folder of ready packages: FEniCSx is not needed
    coarse : with the `[coarse]` variant, in build/NAME-coarse
    force : compute a run that is up to date
    progress : show progress on standard error
    allow_python : run the Python functions that the case names as controllers

    Raises
    ------
    InputError
        A mistake in the case, one line each; a body that cannot be built.
    PackageError
        A package that cannot be read.

    Examples
    --------
    >>> import plymotion as pm
    >>> result = pm.run("pendulum.toml", "base")
    >>> result.signals["tip_z"].min < -0.98
    True
    >>> pm.run("pendulum.toml", "bse")
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: pendulum has no run 'bse'; did you mean 'base'?
    """
    case = as_case(case)
    checked = case.check(coarse=coarse, sweeps=())
    run = run_named(case.name, run, checked.runs)
    folder = folder_of(case, out, coarse=coarse)
    with shown(steps=progress), named(out), turn(folder):
        write_case(checked, folder, None if packages is None else Path(packages))
        file, target = folder / "runs" / f"{run}.json", folder / run
        if packages is None:
            build_packages_of(file)
        if force or not up_to_date(file, target):
            run_one(file, target, progress=progress, allow_python=allow_python)
        return Result(target)


def build_packages_of(file: Path) -> None:
    """Build the packages of a run or sweep file that are missing or out of date.

    FEniCSx stays loaded for the next call, for a minute. Raises InputError.
    """
    keep_preprocessors()
    build_needed([file])


def folder_of(case: Case, out: str | Path | None, *, coarse: bool = False) -> Path:
    """Return the folder of the results of a case."""
    return Path(out) if out is not None else Path("build") / (case.name + "-coarse" * coarse)


def named(out: str | Path | None) -> AbstractContextManager[None]:
    """Return a context in which a folder `out` of the user may be a link, as that of `--out`."""
    return named_by_user([] if out is None else [Path(out)])


def run_named(name: str, run: str | None, runs: Iterable[str]) -> str:
    """Return a run that a case has; None: its only one. Raises InputError."""
    known = list(runs)
    run = run or only_run(name, known)
    if run not in known:
        raise InputError(f"{name} has no run {run!r}{nearest(str(run), known)}")
    return run


def only_run(name: str, runs: Iterable[str]) -> str:
    """Return the only run of a case. Raises InputError."""
    found = list(runs)
    if len(found) != 1:
        raise InputError(f"{name}: expected the name of a run: {few(found)}")
    return found[0]
