"""Exact derivatives of a design: by those that its packages carry, not by other packages.

The specification of a body names the numbers that a parameter sets, and their derivatives, which
are found by comparing specifications beside the design. So it does not matter how a ply is written
in the case. The preprocessor adds derivatives of all arrays to the package (`/design`,
docs/format.md). A run beside the design is then one with packages moved along them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...errors import InputError
from ...inputs.case.bodies.specifications import BodySpec
from ...inputs.case.tables.schema import Mechanism
from ...math.arrays import Array
from ...package.common.plain_data import inputs_sha256
from ...run.inputs import RunSpec

STEP = 1e-5  # of the range of a parameter, along derivatives and between specifications
Specs = Mapping[str, BodySpec]


def beside(p: Array, steps: Array) -> list[Array]:
    """Return a design and those less and plus a step of each parameter: 1 + 2 p of them."""
    return [
        p,
        *(p + s * h * e for h, e in zip(steps, np.eye(p.size), strict=True) for s in (-1, 1)),
    ]


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
) -> list[tuple[RunSpec, ...]]:
    """Return the runs less and plus a step of each parameter, by derivatives of packages.

    Parameters
    ----------
    mechanisms : of the designs of `beside`
    """
    return [
        tuple(
            replace(spec.moved(name, sign * h), mechanism=mechanism)
            for sign, mechanism in zip((-1.0, 1.0), mechanisms[1 + 2 * k :], strict=False)
        )
        for k, (name, h) in enumerate(zip(names, steps.tolist(), strict=True))
    ]
