"""`[sweeps.NAME]` of a case file: many variants of one run with different numbers."""

import itertools
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, Field, model_validator

from ...errors import nearest
from ...math.arrays import Array
from ..common.table import Name, Table

MOST = 100_000  # members of one sweep
Design = Literal["grid", "list", "random", "latin-hypercube"]


class Variation(Table):
    """`[sweeps.NAME.vary]`: a parameter, its keys and its values.

    The parameter's name is the dotted key of the mechanism that it changes, in quotes, such as
    `"bodies.arm.ply_angle_deg"`, numbers counting the places of lists from 0; or any name, with
    `keys`. A list instead of the table gives its `values`.
    """

    keys: list[str] | None = Field(
        default=None,
        min_length=1,
        description="dotted keys that all get the value; absent: the parameter's name",
    )
    values: list[float] | None = Field(default=None, min_length=1, description="its values")
    low: float | None = Field(default=None, alias="from", description="instead of values: first")
    high: float | None = Field(default=None, alias="to", description="last")
    count: int | None = Field(
        default=None,
        ge=2,
        le=MOST,
        description="how many at equal distances; absent in designs that draw from a range",
    )

    @model_validator(mode="before")
    @classmethod
    def _list(cls, table: Any) -> Any:
        return {"values": table} if isinstance(table, list) else table

    @model_validator(mode="after")
    def _one_source(self) -> "Variation":
        span = [self.low, self.high]
        if self.values is not None:
            if [*span, self.count] != [None] * 3:
                raise ValueError("expected either `values` or `from`, `to` and `count`")
        elif None in span:
            raise ValueError("expected `values`, or `from` and `to`")
        return self

    def listed(self) -> list[float]:
        """Return its values in order."""
        if self.values is not None:
            return list(self.values)
        low, high = self._span()
        return [float(v) for v in np.linspace(low, high, self.count or 2)]

    def drawn(self, share: float) -> float:
        """Return the value at a fraction of the range (or list), 0 <= share < 1."""
        if self.values is not None or self.count is not None:
            values = self.listed()
            return values[int(share * len(values))]
        low, high = self._span()
        return low + share * (high - low)

    def _span(self) -> tuple[float, float]:
        """Return both ends of the range; `_one_source` has checked that they exist."""
        if self.low is None or self.high is None:
            raise ValueError("expected `from` and `to`")
        return self.low, self.high


class Sweep(Table):
    """`[sweeps.NAME]`: a run computed many times with other numbers (docs/sweeps.md)."""

    title: str = Field(default="", description="words for figures")
    run: Name = Field(description="name of the run that is varied")
    variants: list[Name] = Field(
        default=[], description="names of variants, applied after those of the run"
    )
    design: Design = Field(
        default="grid",
        description="grid: all combinations; list: the first values of all parameters, the second "
        "ones, ...; random, latin-hypercube: `count` points drawn from the ranges",
    )
    count: int | None = Field(
        default=None, ge=1, le=MOST, description="points of a random or latin-hypercube design"
    )
    seed: int = Field(default=0, ge=0, description="of a random or latin-hypercube design")
    signals: list[Name] = Field(
        default=[], description="signals to keep: final value and extremes; none: all"
    )
    histories: list[Name] = Field(default=[], description="signals to keep at every output time")
    vary: dict[str, Variation] = Field(min_length=1, description="parameters by key or name")

    @model_validator(mode="after")
    def _fitting(self) -> "Sweep":
        drawn = self.design in ("random", "latin-hypercube")
        if drawn != (self.count is not None):
            raise ValueError(
                f'design "{self.design}": expected {"a" if drawn else "no"} `count` of points'
            )
        if drawn:
            return self
        for name, variation in self.vary.items():
            if variation.values is None and variation.count is None:
                raise ValueError(f"vary.{name}: expected `count` beside `from` and `to`")
        sizes = {name: len(variation.listed()) for name, variation in self.vary.items()}
        if self.design == "list" and len(set(sizes.values())) > 1:
            told = ", ".join(f"{size} of {name}" for name, size in sizes.items())
            raise ValueError(f'design "list": expected as many values of each, found {told}')
        if self.design == "grid" and np.prod(list(map(float, sizes.values()))) > MOST:
            raise ValueError(f"expected at most {MOST} combinations")
        return self

    def points(self) -> Array:
        """Return the values of all parameters of every member, (k, p)."""
        variations = list(self.vary.values())
        if self.count is None:
            values = [variation.listed() for variation in variations]
            rows = (
                itertools.product(*values) if self.design == "grid" else zip(*values, strict=True)
            )
            return np.array(list(rows), dtype=float)
        random = np.random.default_rng(self.seed)
        shares = random.random((self.count, len(variations)))
        if self.design == "latin-hypercube":
            # one point in each of `count` slices of every range
            slices = [random.permutation(self.count) for _ in variations]
            shares = (np.array(slices).T + shares) / self.count
        return np.array([[v.drawn(u) for v, u in zip(variations, r, strict=True)] for r in shares])


class Misplaced(Exception):
    """A dotted key that is not the key of a number; the message names its last existing part."""


@dataclass(frozen=True)
class Parameter:
    """What a sweep varies, found in the mechanism."""

    name: str
    keys: list[str]
    unit: str


def parameters_of(sweep: Sweep, mechanism: BaseModel) -> list[Parameter]:
    """Return the parameters with their units. Raises Misplaced."""
    found, owner = [], dict[str, str]()
    for name, variation in sweep.vary.items():
        keys = variation.keys or [name]
        units = [unit_at(mechanism, key) for key in keys]
        for key in keys:
            if key in owner:
                raise Misplaced(f"{key}: varied twice, by {owner[key]} and {name}")
            owner[key] = name
        found.append(Parameter(name, keys, units[0] if len(set(units)) == 1 else ""))
    return found


def split_key(key: str) -> list[str]:
    """Return the parts of a dotted key of a case.

    After a colon it is a key of a description: "sections.tube:laminates.wall.angles_deg.1" is
    the change "laminates.wall.angles_deg.1" of the table sections.tube.
    """
    owner, colon, inner = key.partition(":")
    return [*owner.split("."), *(["changes", inner] if colon else [])]


def unit_at(mechanism: BaseModel, key: str) -> str:
    """Return the unit of the number at a dotted key, "" for none.

    Raises
    ------
    Misplaced
        A part of the key does not exist, or its value is not a number.
    """
    here: Any = mechanism
    unit, way = "", list[str]()
    for part in key.split("."):
        known: list[str]
        if isinstance(here, BaseModel):
            known = list(type(here).model_fields)
        elif isinstance(here, dict):
            known = list(here)
        elif isinstance(here, list):
            known = [str(i) for i in range(len(here))]
        elif here is None:
            raise Misplaced(f"{key}: {'.'.join(way)} is absent in this run")
        else:
            raise Misplaced(f"{key}: {'.'.join(way)} has no keys")
        way.append(part)
        if part not in known:
            raise Misplaced(f"{key}: unknown key {'.'.join(way)}{nearest(part, known)}")
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
        raise Misplaced(f"{key}: expected the key of a number, this is {what}")
    return unit


def changed(table: dict[str, Any], defaults: Any, changes: dict[str, float]) -> dict[str, Any]:
    """Return a copy of a mechanism's table, as the user wrote it, with numbers at dotted keys.

    `defaults` is the complete mechanism, for lists that the user omitted.
    """
    found = dict(table)
    for key, value in changes.items():
        *way, last = key.split(".")
        here: Any = found
        there: Any = defaults
        for part in way:
            there = there[int(part)] if isinstance(there, list) else there[part]
            place: Any = int(part) if isinstance(here, list) else part
            if isinstance(here, dict):
                here.setdefault(part, there if isinstance(there, list) else {})
            here[place] = copy(here[place])  # what does not change is shared with `table`
            here = here[place]
        here[int(last) if isinstance(here, list) else last] = value
    return found


def differences(base: Any, other: Any, way: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Yield dotted keys and values at which plain data differ from `base`."""
    if isinstance(base, dict) and isinstance(other, dict) and base.keys() == other.keys():
        for key in base:
            yield from differences(base[key], other[key], (*way, key))
    elif isinstance(base, list) and isinstance(other, list) and len(base) == len(other):
        for i, (one, two) in enumerate(zip(base, other, strict=True)):
            yield from differences(one, two, (*way, str(i)))
    elif base != other:
        yield ".".join(way), other
