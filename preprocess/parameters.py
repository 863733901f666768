"""Design parameters: numbers of a specification that move together, each by a factor."""

import copy
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..solver.errors import did_you_mean, few
from ..solver.math.arrays import Array
from ..solver.package.common.design import PLACES, TWO_PLACES, difference
from ..solver.package.common.plain_data import expected
from ..solver.package.specification import DesignTarget

KINDS = {"angle_deg": "angle", "thickness": "thickness"}
NEAR = 0.01  # times the distances of places, where a model moves along its derivatives
Key = str | int
# Step of a number from specification, keys and value; raises the error of the reader
Step = Callable[[Mapping[str, Any], tuple[Key, ...], str], float]


@dataclass(frozen=True)
class Target:
    """A number of a specification that a parameter sets, by its keys."""

    keys: tuple[Key, ...]
    factor: float
    offset: float

    @property
    def path(self) -> str:
        """The keys with dots."""
        return ".".join(map(str, self.keys))

    @property
    def kind(self) -> str:
        """One of angle, thickness, number."""
        return KINDS.get(str(self.keys[-1]), "number")

    @property
    def table(self) -> DesignTarget:
        """The target as a table."""
        return {"of": self.path, "factor": self.factor, "offset": self.offset}


@dataclass(frozen=True)
class Parameter:
    """A parameter of the specification `spec`, and the step of its differences in its unit.

    `where` and `error` are for messages.
    """

    name: str
    targets: tuple[Target, ...]
    spec: Mapping[str, Any]
    step: float
    where: str
    error: type[Exception]
    places: tuple[float, ...] = PLACES

    @property
    def kind(self) -> str:
        """That of all targets; else number."""
        kinds = {target.kind for target in self.targets}
        return kinds.pop() if len(kinds) == 1 else "number"

    def linear(self) -> "Parameter":
        """The same of a model that moves along its derivatives: two near places are enough."""
        return replace(self, step=NEAR * self.step, places=TWO_PLACES)

    def moved(self, distance: float, below: Sequence[Key] = ()) -> Any:
        """The specification with the parameter moved, or the part of it below some keys."""
        spec: Any = copy.copy(self.spec)
        for target in self.targets:
            *way, last = target.keys
            place = spec
            for key in way:
                place[key] = copy.copy(place[key])
                place = place[key]
            place[last] += target.factor * distance
        for key in below:
            spec = spec[key]
        return spec

    def below(self, keys: Sequence[Key]) -> list[DesignTarget]:
        """The targets below some keys, as tables."""
        n = len(keys)
        own = [t for t in self.targets if t.keys[:n] == tuple(keys)]
        return [{**t.table, "of": [*map(str, t.keys[n:])]} for t in own]

    def quotient(self, value: Callable[[float], Array]) -> Any:
        """Derivative of an array as a function of the distance that the parameter is moved."""
        return difference([value(place * self.step) for place in PLACES], self.step)

    def refused(self, why: str) -> Exception:
        """The error that it has no derivative."""
        targets = few(target.path for target in self.targets)
        return self.error(f"{self.where} ({targets}): {why}")


def read_parameters(
    spec: Mapping[str, Any],
    design: Mapping[str, Sequence[DesignTarget]],
    allowed: Sequence[str],
    what: str,
    step: Step,
    where: str,
    error: type[Exception],
) -> tuple[Parameter, ...]:
    """The design parameters of a specification with a checked form.

    Parameters
    ----------
    design : name -> targets {"of": "regions.top.plies.0.angle_deg" or a list of such keys,
        "factor": change of the target per unit of the parameter, 1 by default}
    allowed, what : patterns of the numbers that may be targets, and in words
    step : of differences, in the unit of the number

    Raises `error` for a target that does not exist, is no number, or cannot be a parameter.
    """
    parameters = []
    for name, tables in design.items():
        if not name or "/" in name or name == ".":
            raise error(expected(f"{where}design", name, "a name without '/'"))
        at = f"{where}design.{name}"
        if not tables:
            raise error(expected(at, tables, "at least one target"))
        targets, steps = [], []
        for row, table in enumerate(tables):
            of = table["of"]
            keys: list[Key] = [*(of.split(".") if isinstance(of, str) else of)]
            factor = float(table.get("factor", 1.0))
            if factor == 0.0:
                raise error(expected(f"{at}[{row}].factor", 0.0, "a number other than 0"))
            place: Any = spec
            for count, key in enumerate(keys):
                try:
                    keys[count] = int(key) if isinstance(place, list) else key
                    place = place[keys[count]]
                except (KeyError, IndexError, TypeError, ValueError):
                    known = list(place) if isinstance(place, dict) else []
                    raise error(
                        f"{at}[{row}].of = {'.'.join(map(str, keys))!r}: no {str(key)!r} in "
                        f"{'.'.join(map(str, keys[:count])) or 'the specification'}"
                        f"{did_you_mean(str(key), known)}"
                    ) from None
            target = Target(tuple(keys), factor, float(table.get("offset", 0.0)))
            path = ".".join(str(key).replace(".", "_") for key in keys)
            if not any(re.fullmatch(pattern, path) for pattern in allowed):
                text = f"a number that can be a design parameter ({what})"
                raise error(expected(f"{at}[{row}].of", target.path, text))
            if isinstance(place, bool) or not isinstance(place, int | float):
                text = f"expected the path of a number, found {place!r}"
                raise error(f"{at}[{row}].of = {target.path!r}: {text}")
            steps.append(step(spec, target.keys, f"{at}[{row}].of") / abs(factor))
            targets.append(target)
        parameters.append(Parameter(name, tuple(targets), spec, min(steps), at, error))
    return tuple(parameters)
