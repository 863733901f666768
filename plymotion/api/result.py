"""`plymotion.run` and the result of a run: signals by name, energies, warnings, tables."""

from collections.abc import Iterable
from contextlib import AbstractContextManager
from functools import cached_property
from pathlib import Path
from typing import Any
from weakref import WeakSet

import numpy as np

from ..solver.errors import InputError, counted, few, nearest
from ..solver.inputs.case.design import Case as CheckedCase
from ..solver.math.arrays import Array
from ..solver.math.compiled import tell_if_slow
from ..solver.package.common.files import named_by_user
from ..solver.results import RunResult, Summary, read_result, read_summary
from ..solver.results.codes import Entry
from ..solver.run.inputs import up_to_date
from ..solver.studies.cases import folder_lock
from ..solver.studies.exit_codes import shown
from ..solver.studies.runs import run_one
from ..solver.workers.launch import keep_preprocessors
from ..solver.workers.packages import prepared
from .case import ByName, Case, as_case
from .signal import Signal, pandas, pyplot, signals_table, table


class Result:
    """The results of a run.

    Attributes
    ----------
    folder : path of the folder with result.vtkhdf and summary.json
    summary : content of summary.json (docs/runs.md)

    Examples
    --------
    >>> import plymotion as pm
    >>> result = pm.run("pendulum.toml")
    >>> result
    <Result pendulum/base: finished at t = 1 s, 3 signals>
    >>> result.signals["angle"].unit
    'rad'
    >>> result.signals["angel"]
    Traceback (most recent call last):
    plymotion.api.case.UnknownName: no 'angel' among the signals; did you mean 'angle'?
    """

    def __init__(self, folder: str | Path, summary: Summary | None = None) -> None:
        self.folder = Path(folder)
        self.summary = read_summary(self.folder / "summary.json") if summary is None else summary
        self._file = (self.folder / "result.vtkhdf").absolute()
        self._stamp = _stamp(self._file)
        _MADE.add(self)

    @classmethod
    def from_folder(cls, folder: str | Path) -> "Result":
        """Return the result of a run from its folder. Raises InputError.

        >>> import plymotion as pm
        >>> pm.Result.from_folder(pm.run("pendulum.toml").folder).run
        'base'
        """
        runs = sorted(file.parent for file in Path(folder).glob("*/summary.json"))
        if runs and not (Path(folder) / "summary.json").exists():
            raise InputError(f"{folder}: expected the folder of a run, such as {runs[0]}")
        return cls(folder)

    @cached_property
    def data(self) -> RunResult:
        """All arrays of result.vtkhdf: positions, velocities, multipliers, points of bodies.

        >>> import plymotion as pm
        >>> data = pm.run("pendulum.toml").data
        >>> data.q.shape[0] == data.t.size
        True
        """
        now = _stamp(self._file)
        if self._stamp is not None and now not in (None, self._stamp):
            raise InputError(
                f"{self._file}: a later run has replaced it; expected another folder for that, by "
                "out="
            )
        return read_result(self._file)

    @property
    def case(self) -> str:
        """Name of the case.

        >>> import plymotion as pm
        >>> pm.run("pendulum.toml").case
        'pendulum'
        """
        return str(self.summary["case"])

    @property
    def run(self) -> str:
        """Name of the run.

        >>> import plymotion as pm
        >>> pm.run("pendulum.toml").run
        'base'
        """
        return str(self.summary["run"])

    @property
    def status(self) -> str:
        """How the run ended: finished, stopped, failed, interrupted.

        >>> import plymotion as pm
        >>> pm.run("pendulum.toml").status
        'finished'
        """
        return str(self.summary["status"])

    @property
    def completed(self) -> bool:
        """Whether the run reached its end time.

        >>> import plymotion as pm
        >>> pm.run("pendulum.toml").completed
        True
        """
        return bool(self.summary["completed"])

    @property
    def warnings(self) -> list[Entry]:
        """Warnings with `code` and `message` (docs/warnings.md).

        >>> import plymotion as pm
        >>> pm.run("pendulum.toml").warnings
        []
        """
        return list(self.summary["warnings"])

    @property
    def t(self) -> Array:
        """Output times (k,) [s].

        >>> import plymotion as pm
        >>> pm.run("pendulum.toml").t.shape
        (101,)
        """
        return self.data.t

    @cached_property
    def signals(self) -> ByName[Signal]:
        """Signals of the case by name.

        >>> import plymotion as pm
        >>> pm.run("pendulum.toml").signals
        <3 signals: angle, tip_x, tip_z>
        """
        return signals_of(self.data)

    @cached_property
    def energies(self) -> ByName[Signal]:
        """Energies by name: kinetic, strain, potential, drive_work, and their balance.

        >>> import plymotion as pm
        >>> result = pm.run("pendulum.toml")
        >>> result.energies["balance"].peak_to_peak < 1e-4 * result.energies["kinetic"].max
        True
        """
        balance = self.data.energy_balance
        histories = {**self.data.energies, "balance": balance}
        return ByName("energies", {n: Signal(n, "J", "", self.t, v) for n, v in histories.items()})

    def to_pandas(self) -> Any:
        """Return a DataFrame of all signals over time. Raises ImportError without pandas.

        >>> import plymotion as pm
        >>> table = pm.run("pendulum.toml").to_pandas()
        >>> list(table.columns)
        ['angle', 'tip_x', 'tip_z']
        """
        pd = pandas()
        columns = {name: np.asarray(signal) for name, signal in self.signals.items()}
        return pd.DataFrame(columns, index=pd.Index(self.t, name="t"))

    def plot(self, *names: str) -> Any:
        """Draw signals over time, a panel each, with matplotlib; return the figure.

        Parameters
        ----------
        names : of the signals; none: all

        >>> import plymotion as pm
        >>> figure = pm.run("pendulum.toml").plot("tip_x", "tip_z")
        >>> len(figure.axes)
        2
        """
        chosen = [self.signals[name] for name in names or self.signals]
        figure, axes = pyplot().subplots(
            len(chosen), 1, sharex=True, squeeze=False, layout="constrained"
        )
        for signal, panel in zip(chosen, axes[:, 0], strict=True):
            signal.plot(panel)
        for panel in axes[:-1, 0]:
            panel.set_xlabel("")
        return figure

    def __repr__(self) -> str:
        parts = [f"{self.status} at t = {self.summary['t_end']:.4g} s"]
        parts.append(counted(len(self.summary["signals"]), "signal"))
        if self.warnings:
            parts.append(f"warnings: {', '.join(w['code'] for w in self.warnings)}")
        return f"<Result {self.case}/{self.run}: {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        page = signals_table(list(self.signals.values()), repr(self).strip("<>"))
        if self.warnings:
            rows = [[w["code"], w["message"]] for w in self.warnings]
            page += table(["warning", ""], rows)
        return page


_MADE: WeakSet[Result] = WeakSet()  # which may not have read their files


def _stamp(file: Path) -> tuple[int, int] | None:
    """Return what tells a file from a later one in its place, if it is there."""
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns


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
    checked, run, folder = chosen(case, run, out, coarse=coarse)
    with shown(steps=progress), named(out), folder_lock(folder):
        file, target = written(checked, folder, f"runs/{run}.json", packages), folder / run
        if force or not up_to_date(file, target):
            tell_if_slow()
            there = (target / "result.vtkhdf").absolute()
            for made in list(_MADE):  # a later result in the same folder is not theirs
                if made._file == there and made._stamp == _stamp(there) is not None:
                    _ = made.data
            run_one(file, target, progress=progress, allow_python=allow_python)
        return Result(target)


def chosen(
    case: Case | str | Path,
    run: str | None,
    out: str | Path | None = None,
    *,
    coarse: bool = False,
) -> tuple[CheckedCase, str, Path]:
    """Return a checked case, the name of a run and the folder of results. Raises InputError.

    Parameters
    ----------
    case : case, or its file
    run : name of the run; None: the only one
    out : folder of the results; None: build/CASE
    coarse : with the changes of [coarse]
    """
    case = as_case(case)
    checked = case.check(coarse=coarse, sweeps=())
    return checked, run_named(case.name, run, checked.runs), folder_of(case, out, coarse=coarse)


def written(checked: CheckedCase, folder: Path, file: str, packages: str | Path | None) -> Path:
    """Write a case; return a run or sweep file of it, whose packages are up to date.

    FEniCSx stays loaded for the next call, for a minute. Raises InputError.

    Parameters
    ----------
    packages : folder of ready packages; None: they are built where that is necessary
    """
    keep_preprocessors()
    return prepared(checked, folder, file, path_of(packages))


def path_of(folder: str | Path | None) -> Path | None:
    """Return the path of a folder that may be absent."""
    return None if folder is None else Path(folder)


def signals_of(data: RunResult) -> ByName[Signal]:
    """Return the signals of a result by name."""
    signals = (Signal(s.name, s.unit, s.description, data.t, s.values) for s in data.signals)
    return ByName("signals", {signal.name: signal for signal in signals})


def folder_of(case: Case, out: str | Path | None, *, coarse: bool = False) -> Path:
    """Return the folder of the results of a case.

    Parameters
    ----------
    case : case
    out : folder that was asked for; None: build/CASE
    coarse : with the changes of [coarse]
    """
    return Path(out) if out is not None else Path("build") / (case.name + "-coarse" * coarse)


def named(out: str | Path | None) -> AbstractContextManager[None]:
    """Return a context in which a folder `out` of the user may be a link, as that of `--out`."""
    return named_by_user([] if out is None else [Path(out)])


def run_named(name: str, run: str | None, runs: Iterable[str]) -> str:
    """Return a run that a case has; None: its only one. Raises InputError.

    Parameters
    ----------
    name : name of the case
    run : name of the run; None: the only one
    runs : names of its runs
    """
    known = list(runs)
    if run is None and len(known) != 1:
        raise InputError(f"{name}: expected the name of a run: {few(known)}")
    run = known[0] if run is None else run
    if run not in known:
        raise InputError(f"{name} has no run {run!r}{nearest(str(run), known)}")
    return run
