"""`plymotion.openmdao_component`: a study of a case as a component of OpenMDAO."""

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.errors import InputError
from ..solver.studies.design.starts import Known
from ..solver.studies.design.study import ready
from .case import Case
from .optimising import study_spec


def openmdao_component(
    case: Case | str | Path,
    study: str | None = None,
    *,
    out: str | Path | None = None,
    coarse: bool = False,
) -> Any:
    """Return an `ExplicitComponent` with the values and derivatives of a study; docs/design.md.

    Its inputs are the parameters, in the units of the case. Its outputs are the objective and the
    limits by their words: a number, or the highest peaks over time; of a strength exposures 1 / R.
    Bounds, limits and rules belong to the driver of OpenMDAO. An invalid design is an
    `AnalysisError`.

    Parameters
    ----------
    case, study, out, coarse : as for `optimise`

    Raises
    ------
    InputError
        A mistake in the case or the study; OpenMDAO is missing; an invalid first design.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.openmdao_component("pendulum.toml", "heavy")
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: pendulum: expected the name of a study; known: light
    """
    given = study_spec(case, study, out, coarse=coarse)
    try:
        om: Any = import_module("openmdao.api")
    except ImportError as error:
        raise InputError(
            f"openmdao_component: needs openmdao ({error}): pip install openmdao"
        ) from error
    _, trials, memory = ready(given)
    own, known = trials.study, Known(trials, memory)
    first = known.values(own.start)
    if first.why:
        raise InputError(f"{given.file}: the design of the start is invalid: {first.why}")
    names = [q.words().replace(" ", "_") for q in own.table.quantities()]
    outputs = [w if names.count(w) == 1 else f"{w}_{k}" for k, w in enumerate(names)]

    class Designs(om.ExplicitComponent):  # type: ignore[misc]
        """The study."""

        def setup(self) -> None:
            for name, value in zip(own.parameters, own.start.tolist(), strict=True):
                self.add_input(name, value)
            for name, values in zip(outputs, first.values, strict=True):
                self.add_output(name, np.array(values))
            self.declare_partials("*", "*")

        def compute(self, inputs: Any, components: Any, *_: Any) -> None:
            values = known.values(self._point(inputs))
            if values.why:
                raise om.AnalysisError(values.why)
            for name, each in zip(outputs, values.values, strict=True):
                components[name] = each

        def compute_partials(self, inputs: Any, partials: Any, *_: Any) -> None:
            for name, rates in zip(outputs, known.slopes(self._point(inputs)), strict=True):
                for parameter, column in zip(own.parameters, np.transpose(rates), strict=True):
                    partials[name, parameter] = column

        def _point(self, inputs: Any) -> Any:
            return np.array([float(inputs[name][0]) for name in own.parameters])

    return Designs()
