"""The result of a run in Python: signals by name, energies, warnings, tables."""

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.errors import counted
from ..solver.math.arrays import Array
from ..solver.results import RunResult, read_result, read_summary
from .frames import pandas
from .html import table
from .names import ByName
from .signal import Signal, pyplot, signals_table


class Result:
    """What a run has left in its folder.

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
    plymotion.api.names.UnknownName: no 'angel' among the signals; did you mean 'angle'?
    """

    def __init__(self, folder: str | Path, summary: dict[str, Any] | None = None) -> None:
        self.folder = Path(folder)
        self.summary = read_summary(self.folder / "summary.json") if summary is None else summary

    @classmethod
    def from_folder(cls, folder: str | Path) -> "Result":
        """Return the result in a folder that a run has left. Raises InputError.

        >>> import plymotion as pm
        >>> pm.Result.from_folder(pm.run("pendulum.toml").folder).run
        'base'
        """
        return cls(folder)

    @cached_property
    def data(self) -> RunResult:
        """All arrays of result.vtkhdf: positions, velocities, multipliers, points of bodies.

        >>> import plymotion as pm
        >>> data = pm.run("pendulum.toml").data
        >>> data.q.shape[0] == data.t.size
        True
        """
        return read_result(self.folder / "result.vtkhdf")

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
    def warnings(self) -> list[dict[str, Any]]:
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
        return ByName(
            "signals",
            {
                s.name: Signal(s.name, s.unit, s.description, self.t, s.values)
                for s in self.data.signals
            },
        )

    @cached_property
    def energies(self) -> ByName[Signal]:
        """Energies by name: kinetic, strain, potential, drive_work, and their balance.

        >>> import plymotion as pm
        >>> result = pm.run("pendulum.toml")
        >>> result.energies["balance"].peak_to_peak < 1e-4 * result.energies["kinetic"].max
        True
        """
        balance = self.data.energy_balance
        found = {**self.data.energies, "balance": balance}
        return ByName("energies", {n: Signal(n, "J", "", self.t, v) for n, v in found.items()})

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
        words = [f"{self.status} at t = {self.summary['t_end']:.4g} s"]
        words.append(counted(len(self.summary["signals"]), "signal"))
        if self.warnings:
            words.append(f"warnings: {', '.join(w['code'] for w in self.warnings)}")
        return f"<Result {self.case}/{self.run}: {', '.join(words)}>"

    def _repr_html_(self) -> str:
        page = signals_table(list(self.signals.values()), repr(self).strip("<>"))
        if self.warnings:
            rows = [[w["code"], w["message"]] for w in self.warnings]
            page += table(["warning", ""], rows)
        return page
