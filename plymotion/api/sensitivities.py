"""`plymotion.sensitivities`: derivatives of the signals of a run by numbers of its case."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from ..solver.math.arrays import Array
from ..solver.package.common.plain_data import plain
from ..solver.results import RunResult, Summary
from ..solver.studies.cases import folder_lock
from ..solver.studies.design.gradient import (
    Asked,
    compute_gradient,
    compute_sensitivities,
    gradient_table,
)
from ..solver.studies.exit_codes import shown
from ..solver.studies.sensitivities.case_sensitivities import (
    scaled,
    sensitivity_table,
    write_sensitivities,
)
from .case import ByName, Case, as_case
from .result import chosen, named, path_of, signals_of
from .signal import Signal, table


class Sensitivities:
    """Derivatives of the signals of a run by numbers of its case; docs/sensitivities.md.

    Attributes
    ----------
    t : (k,) output times [s]
    data : content of result.vtkhdf
    summary : content of summary.json

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.sensitivities("pendulum.toml", of=["gravity.2", "bodies.rod.mass"])
    <Sensitivities pendulum/base: 3 signals by gravity.2, bodies.rod.mass>
    """

    def __init__(self, result: RunResult, summary: Summary) -> None:
        self.data, self.summary, self.t = result, summary, result.t

    @cached_property
    def signals(self) -> ByName[Signal]:
        """Signals of the run by name.

        >>> import plymotion as pm
        >>> list(pm.sensitivities("pendulum.toml", of=["gravity.2"]).signals)
        ['angle', 'tip_x', 'tip_z']
        """
        return signals_of(self.data)

    @cached_property
    def parameters(self) -> ByName[float]:
        """Values of the parameters by key.

        >>> import plymotion as pm
        >>> pm.sensitivities("pendulum.toml", of=["gravity.2"]).parameters["gravity.2"]
        -9.81
        """
        return ByName("parameters", {one.parameter: one.value for one in self.data.sensitivities})

    @property
    def gradient(self) -> ByName[float]:
        """Derivatives of the objective by key, in its unit per unit of the key.

        >>> import plymotion as pm
        >>> rms = {"signal": "angle", "of": "rms"}
        >>> found = pm.sensitivities("pendulum.toml", of=["gravity.2"], objective=rms)
        >>> list(found.gradient)
        ['gravity.2']
        """
        return ByName("parameters", self.summary.get("objective", {}).get("derivatives", {}))

    @cached_property
    def derivatives(self) -> ByName[ByName[Array]]:
        """Derivatives (k,) by signal and key, in units of the signal per unit of the key.

        >>> import plymotion as pm
        >>> found = pm.sensitivities("pendulum.toml", of=["gravity.2", "bodies.rod.mass"])
        >>> found.derivatives["angle"]["gravity.2"].shape
        (101,)
        """
        by_signal: dict[str, dict[str, Array]] = {}
        for one in self.data.sensitivities:
            by_signal.setdefault(one.signal, {})[one.parameter] = one.values
        return ByName(
            "signals", {name: ByName("parameters", own) for name, own in by_signal.items()}
        )

    def write(self, folder: str | Path) -> list[Path]:
        """Write result.vtkhdf, with /sensitivities, summary.json and report.html; return them.

        >>> import plymotion as pm
        >>> found = pm.sensitivities("pendulum.toml", of=["gravity.2"])
        >>> [file.name for file in found.write("build/sensitivities")]
        ['result.vtkhdf', 'summary.json', 'report.html']
        """
        with named(folder):
            names = write_sensitivities(Path(folder), self.data, self.summary)
            return [Path(folder) / name for name in names]

    def __str__(self) -> str:
        return gradient_table(self.summary) if self.gradient else sensitivity_table(self.data)

    def __repr__(self) -> str:
        keys = ", ".join(self.parameters or self.gradient)
        return (
            f"<Sensitivities {self.data.case}/{self.data.run}: {len(self.data.signals)} signals "
            f"by {keys}>"
        )

    def _repr_html_(self) -> str:
        rows = [
            [one.signal, one.parameter, one.value, *scaled(one)] for one in self.data.sensitivities
        ]
        head = ["signal", "parameter", "value", "peak", "rms"]
        return table(head, rows, repr(self).strip("<>"))


def sensitivities(
    case: Case | str | Path,
    run: str | None = None,
    *,
    of: Sequence[str] = (),
    packages: str | Path | None = None,
    coarse: bool = False,
    progress: bool = False,
    objective: Mapping[str, Any] | None = None,
) -> Sensitivities:
    """Differentiate the signals of a run by numbers of its case.

    Parameters
    ----------
    case, run, packages, coarse, progress : as for `plymotion.run`
    of : keys of numbers, as in sweeps; names of `[design.parameters]`, or of parameters by which
        packages have derivatives; none: all of `[design.parameters]` with numbers
    objective : one number in place of all signals, as in `minimise` of a study; its derivatives,
        by the adjoint of the run, are the `gradient`

    Raises
    ------
    InputError
        A mistake in the case; a key that is none of a number of the mechanism; what has no
        derivative, or one that is not implemented, by name.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.sensitivities("pendulum.toml", of=["gravity.3"])
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: pendulum.toml: --of gravity.3: unknown key \
gravity.3; known: 0, 1, 2
    """
    case = as_case(case)
    _, run, folder = chosen(case, run, coarse=coarse)
    with shown(steps=progress), folder_lock(folder):
        asked = Asked(plain(case.table), case._path, run, of, folder, path_of(packages), coarse)
        if objective is not None:
            found = compute_gradient(asked, plain(objective))
        else:
            found = compute_sensitivities(asked, progress=progress)
        return Sensitivities(*found)
