"""`[sweeps.NAME]` of a case file: many variants of one run with different numbers.

sweep_members.py finds the keys in the mechanism and makes the members.
"""

import itertools
from typing import Any, Literal

import numpy as np
from pydantic import ConfigDict, model_validator

from ....math.arrays import Array
from ...common.table import Name, Table, entry, optional

MOST = 100_000  # members of one sweep
Design = Literal["grid", "list", "random", "latin-hypercube"]


class Variation(Table):
    """`[sweeps.NAME.vary]`: a parameter, its keys and its values.

    The parameter's name is the dotted key of the mechanism that it changes, in quotes, such as
    `"bodies.arm.ply_angle_deg"`, numbers counting the places of lists from 0; or any name, with
    `keys`, or used by the expressions of `set`. After a colon, a key goes into the description of
    a section or shell: `"sections.tube:laminates.wall.angles_deg.1"`. A list instead of the table
    gives its `values`.
    """

    # A list of numbers is valid in an editor, too.
    model_config = ConfigDict(
        json_schema_extra={"type": ["object", "array"], "items": {"type": "number"}}
    )

    keys: list[str] | None = optional(
        "dotted keys that all get the value; absent: the parameter's name, unless `set` uses it",
        min_length=1,
    )
    unit: str | None = optional("for figures and tables; absent: that of its keys")
    values: list[float] | None = optional("its values", min_length=1)
    low: float | None = optional("instead of values: first", alias="from")
    high: float | None = optional("last", alias="to")
    count: int | None = optional(
        "how many at equal distances; absent in designs that draw from a range", ge=2, le=MOST
    )

    @model_validator(mode="before")
    @classmethod
    def _list(cls, table: Any) -> Any:
        items = table.items() if isinstance(table, dict) else ()
        if any(isinstance(value, dict) or name.isdecimal() for name, value in items):
            raise ValueError('expected quotes around a dotted key, such as "bodies.arm.length"')
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

    title: str = entry("words for figures", default="")
    run: Name = entry("name of the run that is varied")
    variants: list[Name] = entry("names of variants, applied after those of the run", default=[])
    design: Design = entry(
        "grid: all combinations; list: the first values of all parameters, the second ones, ...; "
        "random, latin-hypercube: `count` points drawn from the ranges",
        default="grid",
    )
    count: int | None = optional("points of a random or latin-hypercube design", ge=1, le=MOST)
    seed: int = entry("of a random or latin-hypercube design", default=0, ge=0)
    signals: list[Name] = entry("signals to keep: final value and extremes; none: all", default=[])
    histories: list[Name] = entry("signals to keep at every output time", default=[])
    vary: dict[str, Variation] = entry("parameters by key or name", min_length=1)
    expressions: dict[str, str] = entry(
        'dotted keys and what they get: expressions of parameters, such as "-angle" or "2*t", '
        "which also read `[parameters]` of the case",
        default={},
        alias="set",
    )

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
