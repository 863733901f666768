"""Exact derivatives of a design: by those that its packages carry, not by other packages.

The specification of a body names the numbers that a parameter sets, and their derivatives, which
are found by comparing specifications beside the design. So it does not matter how a ply is written
in the case. The preprocessor adds derivatives of all arrays to the package (`/design`,
docs/format.md). A run beside the design is then one with packages moved along them, and its motion
that of the design moved along the tangent.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...checks.finished import FinishedRun
from ...errors import InputError
from ...inputs.case.bodies.specifications import BodySpec
from ...inputs.case.tables.schema import Mechanism
from ...math.arrays import Array
from ...package.common.plain_data import inputs_sha256
from ...run.inputs import RunSpec
from ...run.preparation import Prepared
from ..sensitivities.execution import Followed, Trace, followed, sensors_beside
from ..sensitivities.parameters import Parameter
from .measures import Made

STEP = 1e-4  # of the range of a parameter, along derivatives and between specifications
Specs = Mapping[str, BodySpec]
Pair = tuple[RunSpec, RunSpec]


def beside(p: Array, steps: Array, ranges: Array | None = None) -> list[Array]:
    """Return a design and those less and plus a step of each parameter: 1 + 2 p of them.

    With `ranges` (p, 2) those of a parameter at a bound are moved inwards: a case may not have an
    angle beyond 90 degrees.
    """
    moved = np.zeros(p.size)
    if ranges is not None:
        moved = np.clip(p, ranges[:, 0] + steps, ranges[:, 1] - steps) - p
    return [p, *(p + (m + s * h) * e for m, h, e in zip(moved, steps, np.eye(p.size), strict=True)
                 for s in (-1, 1))]  # fmt: skip


def with_targets(names: Sequence[str], specs: Sequence[Specs], steps: Array) -> dict[str, BodySpec]:
    """Return specifications of bodies that ask for derivatives.

    Parameters
    ----------
    names : of the parameters
    specs : of the designs of `beside`

    Raises
    ------
    InputError
        A parameter that changes more than numbers: another mesh, another count of elements.
    """
    found = dict(specs[0])
    for body, spec in specs[0].items():
        design = {}
        for k, name in enumerate(names):
            minus, plus = specs[1 + 2 * k][body], specs[2 + 2 * k][body]
            if plus.inputs_sha256 != minus.inputs_sha256:
                where = f"parameter {name}, body {body}"
                design[name] = list(_targets(where, minus.content, plus.content, 2.0 * steps[k]))
        if design:
            content: Any = {**spec.content, "design": design}
            found[body] = replace(spec, content=content, inputs_sha256=inputs_sha256(content))
    return found


def _targets(where: str, minus: Any, plus: Any, h: float) -> Iterator[dict[str, object]]:
    """Yield the paths of numbers that differ, with their derivatives."""
    low, high = dict(_leaves(minus, ())), dict(_leaves(plus, ()))
    if low.keys() != high.keys():
        raise InputError(f"{where}: changes the model, not only its numbers")
    for path, value in low.items():
        other = high[path]
        if value == other:
            continue
        if not (isinstance(value, float) and isinstance(other, float)):
            name = ".".join(path)
            raise InputError(f"{where}: changes {name} from {value!r} to {other!r}")
        yield {"of": list(path), "factor": float(f"{(other - value) / h:.10g}")}


def _leaves(table: Any, way: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    if isinstance(table, Mapping):
        for key, value in table.items():
            yield from _leaves(value, (*way, str(key)))
    elif isinstance(table, list):
        for k, value in enumerate(table):
            yield from _leaves(value, (*way, str(k)))
    else:
        yield way, table


def runs_beside(
    spec: RunSpec, names: Sequence[str], mechanisms: Sequence[Mechanism], steps: Array
) -> list[Pair]:
    """Return the runs less and plus a step of each parameter, by derivatives of packages.

    Parameters
    ----------
    mechanisms : of the designs of `beside`
    """
    return [
        (
            replace(spec.moved(name, -h), mechanism=mechanisms[1 + 2 * k]),
            replace(spec.moved(name, h), mechanism=mechanisms[2 + 2 * k]),
        )
        for k, (name, h) in enumerate(zip(names, steps.tolist(), strict=True))
    ]


@dataclass(frozen=True)
class Traced:
    """A run of a design with its trace: the run itself, or one that its signals read.

    Attributes
    ----------
    signals : that are read of it
    """

    prepared: Prepared
    finished: FinishedRun
    trace: Trace
    signals: Collection[str]

    def followed(self, names: Sequence[str], steps: Array, pairs: Sequence[Pair]) -> Followed:
        """Return it with its tangent; `pairs` are the runs beside it, by parameter."""
        parameters = [
            Parameter(name, "", 0.0, h, *pair)
            for name, h, pair in zip(names, steps.tolist(), pairs, strict=True)
        ]
        y = np.asarray(self.finished.solution.y[:])
        return followed(self.prepared, parameters, self.trace.steps, y)


def made_beside(
    own: str, traced: Mapping[str, Traced], motions: Mapping[str, Followed], k: int, pair: Pair
) -> Iterator[Made]:
    """Yield the designs less and plus the step of parameter k, by the tangents of their runs.

    Parameters
    ----------
    own : name of the run; those that its signals read have others
    pair : the run itself beside the design
    """
    if own not in traced:
        yield from (Made(spec, None, {}, None) for spec in pair)
        return
    histories: tuple[dict[str, Any], dict[str, Any]] = ({}, {})
    for run, motion in motions.items():
        if run == own:
            continue
        for found, (each, recording) in zip(histories, motion.beside(k), strict=True):
            read = sensors_beside(motion.prepared, each, recording, traced[run].signals)
            found[run] = recording.t, {n: s.values(recording) for n, s in read.items()}
    one, motion = traced[own], motions[own]
    for spec, (each, recording), known in zip(pair, motion.beside(k), histories, strict=True):
        read = sensors_beside(motion.prepared, each, recording, one.signals, known)
        yield Made(spec, replace(one.finished, built=each.built), read, recording)
