"""Keys of a sweep: where they are in a mechanism, which units they have, what they get."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import BaseModel

from ....errors import InputError, nearest
from ....math.expressions import operations as op
from ....math.expressions.parse import ExpressionError, Plain, parsed
from ....math.expressions.program import value_at
from ....math.expressions.tree import Node
from ..bodies.descriptions import described
from ..tables.sweeps import Sweep

if TYPE_CHECKING:
    from ..tables.schema import Mechanism


class Misplaced(Exception):
    """A dotted key that is not the key of a number; the message names its last existing part."""


@dataclass(frozen=True)
class Parameter:
    """What a sweep varies, found in the mechanism."""

    name: str
    keys: list[str]
    unit: str


def parameters_of(sweep: Sweep, mechanism: "Mechanism", folder: Path) -> list[Parameter]:
    """Return the parameters with the keys that depend on them, and their units.

    Parameters
    ----------
    folder : of the case file

    Raises
    ------
    Misplaced
        A key that is not that of a number, or given twice; an expression that cannot be used.
    """
    read = {
        key: _reads(key, text, sweep, mechanism.parameters)
        for key, text in sweep.expressions.items()
    }
    owner: dict[str, str] = dict.fromkeys(sweep.expressions, "set")
    units = {key: unit_at(mechanism, key, folder) for key in sweep.expressions}
    found = []
    for name, variation in sweep.vary.items():
        by_expression = [key for key, names in read.items() if name in names]
        own = variation.keys or ([] if by_expression else [name])
        for key in own:
            if key in owner:
                raise Misplaced(f"{key}: varied twice, by {owner[key]} and {name}")
            owner[key] = name
            units[key] = unit_at(mechanism, key, folder)
        keys = [*own, *by_expression]
        unit = variation.unit
        if unit is None:
            direct = own or [k for k in keys if sweep.expressions[k].strip(" -+") == name]
            known = {units[key] for key in direct}
            unit = known.pop() if len(known) == 1 else ""
        found.append(Parameter(name, keys, unit))
    return found


def changes_of(
    sweep: Sweep,
    parameters: Sequence[Parameter],
    values: Mapping[str, float],
    numbers: Mapping[str, float],
) -> dict[str, float]:
    """Return what the keys get in one member: whole numbers as such.

    Parameters
    ----------
    parameters : of `parameters_of`
    values : theirs by name
    numbers : `[parameters]` of the case

    Raises
    ------
    Misplaced
        An expression without a finite value.
    """
    found: dict[str, float] = {}
    for parameter in parameters:
        for key in parameter.keys:
            if key not in sweep.expressions:
                found[key] = values[parameter.name]
    for key, text in sweep.expressions.items():
        try:
            with np.errstate(all="ignore"):
                value = value_at(parsed(text, Plain({**numbers, **values})))
        except (ArithmeticError, ExpressionError) as error:
            raise Misplaced(f'set."{key}" = "{text}": {error}') from error
        if not math.isfinite(value):
            raise Misplaced(f'set."{key}" = "{text}": expected a finite value')
        found[key] = value
    return {key: int(v) if v == int(v) else v for key, v in found.items()}


class _Names(Plain):
    """Varied parameters as quantities that an expression reads, those of the case as numbers."""

    def __init__(self, sweep: Sweep, parameters: Mapping[str, float]) -> None:
        super().__init__(parameters)
        varied = [name for name in sweep.vary if name.isidentifier()]
        self.names |= {name: Node(op.LOAD, quantity=name) for name in varied}


def _reads(key: str, text: str, sweep: Sweep, parameters: Mapping[str, float]) -> set[str]:
    """Return the names of varied parameters that an expression reads. Raises Misplaced."""
    scope = _Names(sweep, parameters)
    try:
        leaves = list(parsed(text, scope).leaves())
    except ExpressionError as error:
        hint = nearest(error.word, scope.names) if error.word else ""
        raise Misplaced(f'set."{key}" = "{text}": {error}{hint}') from error
    if any(leaf.code == op.TIME for leaf in leaves):
        hint = nearest("t", scope.names)
        raise Misplaced(f'set."{key}" = "{text}": there is no parameter `t`{hint}')
    names = {str(leaf.quantity) for leaf in leaves}
    if not names:
        hint = nearest(text, sweep.vary)
        raise Misplaced(f'set."{key}" = "{text}": expected a parameter of `vary`{hint}')
    return names


def unit_at(mechanism: "Mechanism", key: str, folder: Path) -> str:
    """Return the unit of the number at a key, "" for none.

    Raises
    ------
    Misplaced
        A part of the key does not exist, or its value is not a number.
    """
    owner, colon, inner = key.partition(":")
    if not colon:
        return _unit(mechanism, key, key)
    way = owner.split(".")
    try:
        model = described(way, mechanism, folder) if len(way) == 2 else None
    except InputError as error:
        raise Misplaced(f"{key}: {str(error).splitlines()[0]}") from error
    if model is None:
        known = [f"sections.{n}" for n, s in mechanism.sections.items() if hasattr(s, "changes")]
        known += [f"bodies.{n}" for n, b in mechanism.bodies.items() if hasattr(b, "changes")]
        hint = nearest(owner, known)
        raise Misplaced(f"{key}: expected a described section or a shell before the colon{hint}")
    return _unit(model, inner, key)


def _unit(model: BaseModel, key: str, shown: str) -> str:
    """Return the unit at a key below a model; `shown` is the key in messages."""
    here: Any = model
    unit, way = "", list[str]()
    parts = key.split(".")
    for number, part in enumerate(parts):
        known: list[str]
        if isinstance(here, BaseModel):
            known = list(type(here).model_fields)
        elif isinstance(here, dict):
            known = list(here)
        elif isinstance(here, list):
            known = [str(i) for i in range(len(here))]
        elif here is None:
            raise Misplaced(f"{shown}: {'.'.join(way)} is absent in this run")
        else:
            raise Misplaced(f"{shown}: {'.'.join(way)} has no keys")
        way.append(part)
        if part not in known and "changes" in known:
            right = f"{'.'.join(parts[:number])}:{'.'.join(parts[number:])}"
            raise Misplaced(f'{shown}: a key of the description follows a colon, "{right}"')
        if part not in known:
            raise Misplaced(f"{shown}: unknown key {'.'.join(way)}{nearest(part, known)}")
        if isinstance(here, BaseModel):
            extra = type(here).model_fields[part].json_schema_extra
            unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
            here = getattr(here, part)
        else:
            if isinstance(here, list) and "," in unit:  # those of its entries, as text
                unit = ""
            here = here[int(part)] if isinstance(here, list) else here[part]
    if here is not None and (isinstance(here, bool) or not isinstance(here, int | float)):
        what = {str: "text", bool: "true or false", list: "a list"}.get(type(here), "a table")
        raise Misplaced(f"{shown}: expected the key of a number, this is {what}")
    return unit
