"""`plymotion.sweep`: the members of a sweep, computed as the command `plymotion sweep` does."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.errors import InputError, counted, few, nearest
from ..solver.math.arrays import Array
from ..solver.package.common.files import write_text
from ..solver.package.common.plain_data import plain
from ..solver.studies.cases import folder_lock
from ..solver.studies.exit_codes import shown
from ..solver.studies.sweep.file import (
    CSV,
    FILE,
    FINISHED,
    SweepResult,
    read_sweep,
    result_of,
    sweep_csv,
)
from ..solver.studies.sweep.portions import RowFile, settled
from ..solver.studies.sweep.sweep_members import read_sweep_spec
from ..solver.workers.executors import Here, Local
from .case import ByName, Case, as_case
from .result import folder_of, named, run_named, written
from .signal import pandas, pyplot, table


class SweepSignal:
    """A signal of all k members of a sweep.

    Attributes
    ----------
    name, unit, description : text
    final, min, max, t_min, t_max, rms, peak_to_peak : (k,), NaN of a member that failed

    Examples
    --------
    >>> import plymotion as pm
    >>> found = pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base")
    >>> found.signals["tip_z"]
    <SweepSignal tip_z [m]: 2 members, -1 to 0>
    >>> found.signals["tip_z"].min.round(2)
    array([-1.  , -0.91])
    """

    def __init__(self, result: SweepResult, name: str) -> None:
        self._result, self.name = result, name
        self.unit, self.description = result.signal_units[name], result.signal_words[name]
        for measure in result.measures(name):
            setattr(self, measure, result.signal(name, measure))

    final: Array
    min: Array
    max: Array
    t_min: Array
    t_max: Array
    rms: Array
    peak_to_peak: Array

    @property
    def history(self) -> Array:
        """Values over time (k, n_t), of a signal among the histories of the sweep.

        >>> import plymotion as pm
        >>> vary, histories = {"gravity.2": [-9.81, -1.62]}, ["angle"]
        >>> found = pm.sweep("pendulum.toml", "h", run="base", vary=vary, histories=histories)
        >>> found.signals["angle"].history.shape
        (2, 101)
        """
        if not any(self.name in row.histories for row in self._result.rows):
            raise InputError(
                f"{self.name}: its values over time were not kept; expected it among histories"
            )
        return self._result.history(self.name)

    def __repr__(self) -> str:
        known = np.isfinite(self.min)
        span = f"{self.min[known].min():.3g} to {self.max[known].max():.3g}" if known.any() else "-"
        return f"<SweepSignal {self.name} [{self.unit}]: {len(known)} members, {span}>"


class Sweep:
    """The results of a sweep.

    Attributes
    ----------
    folder : path of the folder with sweep.h5
    data : content of sweep.h5 (docs/sweeps.md)

    Examples
    --------
    >>> import plymotion as pm
    >>> found = pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base")
    >>> found
    <Sweep pendulum/python: 2 members, 2 finished, over gravity.2>
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.data: SweepResult = read_sweep(self.folder / FILE)

    @classmethod
    def from_folder(cls, folder: str | Path) -> "Sweep":
        """Return the sweep in a folder. Raises InputError.

        >>> import plymotion as pm
        >>> found = pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base")
        >>> len(pm.Sweep.from_folder(found.folder).status)
        2
        """
        return cls(folder)

    @cached_property
    def parameters(self) -> ByName[Array]:
        """Values of the parameters (k,) by name.

        >>> import plymotion as pm
        >>> found = pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base")
        >>> found.parameters["gravity.2"]
        array([-9.81, -1.62])
        """
        columns = zip(self.data.parameter_names, self.data.values.T, strict=True)
        return ByName("parameters", dict(columns))

    @cached_property
    def signals(self) -> ByName[SweepSignal]:
        """Signals by name, each with its measures of all members.

        >>> import plymotion as pm
        >>> found = pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base")
        >>> found.signals["tip_x"].final.round(3)
        array([-1.   ,  0.405])
        """
        by_name = {name: SweepSignal(self.data, name) for name in self.data.signal_units}
        return ByName("signals", by_name)

    @cached_property
    def status(self) -> list[str]:
        """How each member ended: finished, stopped, failed.

        >>> import plymotion as pm
        >>> pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base").status
        ['finished', 'finished']
        """
        return [row.status for row in self.data.rows]

    def to_pandas(self) -> Any:
        """Return a DataFrame: a row for each member. Raises ImportError without pandas.

        >>> import plymotion as pm
        >>> found = pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base")
        >>> found.to_pandas()["tip_z min"].round(2).tolist()
        [-1.0, -0.91]
        """
        pd = pandas()
        columns: dict[str, object] = dict(self.parameters)
        columns["status"] = self.status
        for name in self.data.signal_units:
            for measure in self.data.measures(name):
                columns[f"{name} {measure}"] = self.data.signal(name, measure)
        return pd.DataFrame(columns)

    def plot(self, signal: str, measure: str = "max", axes: Any = None, **style: Any) -> Any:
        """Draw a measure of a signal over the first parameter with matplotlib; return the axes.

        Parameters
        ----------
        signal : name of the signal
        measure : "max", "min" or another measure of the sweep's file
        axes : axes of matplotlib; None: the current ones
        style : options of matplotlib's `plot`

        >>> import plymotion as pm
        >>> found = pm.sweep("pendulum.toml", vary={"gravity.2": [-9.81, -1.62]}, run="base")
        >>> found.plot("tip_z", "min").get_xlabel()
        'gravity.2 [m/s2]'
        """
        axes = pyplot().gca() if axes is None else axes
        name, unit = self.data.parameter_names[0], self.data.parameter_units[0]
        x, values = self.parameters[name], self.signals[signal]
        if measure not in (known := self.data.measures(signal)):
            raise InputError(f"{signal} has no measure {measure!r}{nearest(measure, known)}")
        order = np.argsort(x, kind="stable")
        axes.plot(x[order], getattr(values, measure)[order], **{"marker": "o", **style})
        label = f"{values.description or signal}, {measure} [{values.unit}]"
        axes.set(xlabel=f"{name} [{unit}]" if unit else name, ylabel=label)
        return axes

    def __repr__(self) -> str:
        data, done = self.data, self.status.count(FINISHED)
        return (
            f"<Sweep {data.case}/{data.name}: {counted(len(data.rows), 'member')}, "
            f"{done} finished, over {', '.join(data.parameter_names)}>"
        )

    def _repr_html_(self) -> str:
        signals = list(self.signals.values())
        head = ["member", *self.data.parameter_names, "status", *(f"{s.name} max" for s in signals)]
        rows = [
            [k, *map(float, self.data.values[k]), status, *(float(s.max[k]) for s in signals)]
            for k, status in enumerate(self.status)
        ]
        return table(head, rows, repr(self).strip("<>"))


def sweep(
    case: Case | str | Path,
    name: str | None = None,
    *,
    run: str | None = None,
    vary: Mapping[str, Any] | None = None,
    expressions: Mapping[str, str] | None = None,
    signals: Sequence[str] = (),
    histories: Sequence[str] = (),
    out: str | Path | None = None,
    packages: str | Path | None = None,
    coarse: bool = False,
    fresh: bool = False,
    jobs: int = 1,
    progress: bool = False,
) -> Sweep:
    """Compute the members of a sweep of a case, or those that are missing; docs/sweeps.md.

    Parameters
    ----------
    case : a case, or its file
    name : of a sweep of the case; with `vary`, of the new one, absent: "python"
    run, vary, expressions, signals, histories : instead of a sweep of the case: the run, its
        parameters with their values, `set` of the sweep, what is kept
    out, packages, coarse : as for `run`
    fresh : compute all members again
    jobs : processes
    progress : show progress on standard error

    Raises
    ------
    InputError
        A mistake in the case or the sweep; a body that cannot be built.
    KeyboardInterrupt
        Ctrl-C; finished members are kept.

    Examples
    --------
    >>> import plymotion as pm
    >>> case = pm.load("pendulum.toml")
    >>> found = pm.sweep(case, run="base", vary={"bodies.rod.centre.0": [0.25, 0.5]})
    >>> bool(found.signals["tip_z"].final[0] != found.signals["tip_z"].final[1])
    True
    """
    case = as_case(case)
    if vary is None:
        new = {"run": run, "expressions": expressions, "signals": signals, "histories": histories}
        for key in (key for key, value in new.items() if value):
            raise InputError(f"sweep(): {key} belongs to a new sweep; expected vary= with it")
        if name is None:
            known = f": {few(case.sweeps)}" if case.sweeps else "; the case has none"
            raise InputError(f"{case.name}: expected the name of a sweep, or vary={known}")
    else:
        name = name or "python"
        case = deepcopy(case)
        own = {
            "run": run or run_named(case.name, None, case.runs),
            "vary": _listed(vary),
            "set": expressions or {},
        }
        case.sweeps[name] = {**own, "signals": list(signals), "histories": list(histories)}
    checked = case.check(coarse=coarse, sweeps=[str(name)])
    if name not in checked.sweeps:
        hint = nearest(str(name), checked.top.sweeps)
        raise InputError(f"{case.name} has no sweep {name!r}{hint}")
    folder = folder_of(case, out, coarse=coarse)
    with shown(steps=progress), named(out), folder_lock(folder):
        file = written(checked, folder, f"sweeps/{name}.json", packages)
        _compute(file, jobs, fresh=fresh, progress=progress)
        return Sweep(file.with_suffix(""))


def _compute(file: Path, jobs: int, *, fresh: bool, progress: bool) -> None:
    """Compute a sweep, in this process or in others, which do not import the script of the user."""
    target = file.with_suffix("")
    target.mkdir(parents=True, exist_ok=True)
    sweep = read_sweep_spec(file)
    settled(sweep)
    work = RowFile(sweep, target / FILE, [] if fresh else [target / FILE], show=progress)
    if not work.compute(Here if jobs == 1 else partial(Local, jobs)):
        raise KeyboardInterrupt
    write_text(target / CSV, sweep_csv(result_of(sweep, work.rows)))


def _listed(vary: Mapping[str, Any]) -> dict[str, object]:
    """Return parameters as a case file has them. Raises InputError."""
    values_by_name = {}
    for name, values in vary.items():
        try:
            values_by_name[name] = plain(values if isinstance(values, Mapping) else list(values))
        except TypeError:
            raise InputError(
                f"vary: {name} = {values!r}: expected a list of values, or a table with from, "
                "to and count"
            ) from None
    return values_by_name
