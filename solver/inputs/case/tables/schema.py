"""Every key of a case file, of its sweeps and of a run file."""

import itertools
from collections.abc import Mapping
from copy import copy
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, ValidationError, ValidationInfo, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from ....errors import InputError
from ....math.arrays import Array
from ....math.expressions.operations import TIME
from ....math.expressions.parse import ExpressionError, Plain, parsed
from ....math.expressions.program import value_at
from ...common.input_table import (
    Name,
    Table,
    Vector,
    Word,
    entry,
    follow,
    is_number,
    optional,
    validated,
)
from ...common.materials import Material
from ...common.units import MEANING, UNITS, Unit, unit_of, with_metres
from .beam_keys import BeamBody
from .bodies import ImportedBody, PackageBody, RigidBody, Section, ShellBody, SolidBody
from .design_keys import Design
from .kinds import (
    CaseCoupling,
    CaseForce,
    CaseJoint,
    coordinates_of,
    lengths_along,
)
from .laws import FOLDER, RESOLVED, StateEquation, TablePoints
from .rotor import Rotor
from .signals import Signal
from .solver import Solver

MOST = 100_000  # members of one sweep
Points = Literal["grid", "list", "random", "latin-hypercube"]


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
    unit: str | None = optional(
        "for figures and tables; absent: that of its keys. Of a length: m, cm, mm or in, which its "
        "values then have"
    )
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
        values = table.get("values") if isinstance(table, dict) else table
        if isinstance(values, list) and any(isinstance(value, str) for value in values):
            raise ValueError("expected numbers; words, such as names, are changed by [variants]")
        if not isinstance(table, dict | list):
            raise ValueError(
                "expected a list, such as [0, 30], or { from = 0, to = 90, count = 4 }"
            )
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
    design: Points = entry(
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
                raise ValueError(f"vary.{name}: expected `count` with `from` and `to`")
        sizes = {name: len(variation.listed()) for name, variation in self.vary.items()}
        if self.design == "list" and len(set(sizes.values())) > 1:
            listed = ", ".join(f"{size} of {name}" for name, size in sizes.items())
            raise ValueError(f'design "list": expected as many values of each, found {listed}')
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


Metric = Literal["pointwise", "extremum", "rms"]


class Fidelity(Table):
    """`[fidelity]`: the accuracy that a run must have; docs/fidelity.md."""

    accuracy: float = entry("accepted error of a signal, of its largest value", gt=0, lt=1)
    signals: list[Name] | None = optional(
        "the signals that must have it; absent: all", min_length=1
    )
    metric: Metric = entry(
        "how two histories are compared: pointwise: largest difference at one time; extremum: "
        "difference of their largest and smallest values; rms: root mean square",
        default="pointwise",
    )
    budget: float = entry("CPU time of plan and check; runs end with it", "s", 10.0, gt=0)


Body = Annotated[
    BeamBody | ShellBody | SolidBody | RigidBody | PackageBody | ImportedBody,
    Field(discriminator="kind"),
]


class GroundPoint(Table):
    """`[ground.NAME]`: a point of the ground, used as "ground.NAME"."""

    position: Vector = entry("global", "m")


class PointMass(Table):
    """`[masses.NAME]`: a point mass on a body."""

    mass: float = entry("mass", "kg", gt=0)
    at: str = entry('"BODY.INTERFACE"')


class Mechanism(Table):
    """Keys of one run; a variant may change any of them."""

    allow: list[Literal["material-units", "size-units", "angle-units", "inertia"]] = entry(
        "warnings that are not shown, because the unusual numbers are meant; inertia: rigid bodies "
        "with principal moments that no solid has, as in files of robots",
        default=[],
    )
    gravity: Vector = entry("acceleration of free fall, global", "m/s2", [0.0, 0.0, 0.0])
    materials: dict[Name, Material] = entry("elastic materials", default={})
    sections: dict[Name, Section] = entry("beam cross-sections", default={})
    bodies: dict[Name, Body] = entry("moving bodies", min_length=1)
    ground: dict[Name, GroundPoint] = entry("points of the ground", default={})
    joints: dict[Name, CaseJoint] = entry("constraints", default={})
    couplings: dict[Name, CaseCoupling] = entry(
        "gears, belts, screws: equations between coordinates of joints", default={}
    )
    forces: dict[Name, CaseForce] = entry(
        "springs, loads, stops, friction, controllers", default={}
    )
    parameters: dict[Word, float] = entry(
        "numbers that expressions read by name; a text in place of any number of a case is an "
        'expression of them, such as length = "2*L"',
        default={},
    )
    tables: dict[Word, TablePoints] = entry(
        "curves through points that expressions call by name", default={}
    )
    states: dict[Name, StateEquation] = entry(
        "values by differential equations, which expressions read", default={}
    )
    masses: dict[Name, PointMass] = entry("point masses", default={})
    rotor: Rotor | None = optional("blades in the wind")
    signals: dict[Name, Signal] = entry("what is measured", default={})
    solver: Solver = entry("time integration")
    fidelity: Fidelity | None = optional("the accuracy of a run, by which its model is chosen")

    @model_validator(mode="before")
    @classmethod
    def _along_lengths(cls, data: Any, info: ValidationInfo) -> Any:
        """Convert keys of forces that are lengths or angles, as the coordinate of a joint is."""
        unit, forces = unit_of(info), data.get("forces") if isinstance(data, dict) else None
        if unit == "m" or not isinstance(forces, dict):
            return data
        joints = data.get("joints") if isinstance(data.get("joints"), dict) else {}
        lengths = {k: with_metres(v, unit, lengths_along(v, joints)) for k, v in forces.items()}
        return {**data, "forces": lengths}

    @model_validator(mode="before")
    @classmethod
    def _only_coordinates(cls, data: Any) -> Any:
        """Give signals of joints with one coordinate its name."""
        joints, signals = (isinstance(data, dict) and data.get(k) for k in ("joints", "signals"))
        if not isinstance(joints, dict) or not isinstance(signals, dict):
            return data
        completed = dict(signals)
        for name, signal in signals.items():
            if isinstance(signal, dict) and signal.get("kind") == "joint":
                free = coordinates_of(joints.get(str(signal.get("joint"))))
                if len(free) == 1 and signal.get("coordinate") is None:
                    completed[name] = {**signal, "coordinate": free[0].name}
        return {**data, "signals": completed}


class Run(Table):
    """`[runs.NAME]`: one computation: the case with some variants applied in order."""

    title: str = entry("words for figures and tables", default="")
    variants: list[Name] = entry("names of variants, applied in order", default=[])

    @model_validator(mode="before")
    @classmethod
    def _own_keys(cls, table: Any) -> Any:
        for key in table if isinstance(table, dict) else ():
            if key in {**Mechanism.model_fields, **Solver.model_fields} and key != "title":
                where = "" if key in Mechanism.model_fields else ".solver"
                raise ValueError(f"{key}: expected it in a variant, [variants.NAME{where}]")
        return table


class Figure(Table):
    """`[figures.NAME]`: one signal of several runs in one picture."""

    title: str = entry("title of the picture")
    signal: Name = entry("name of a signal")
    runs: list[Name] = entry("names of runs", min_length=1)
    spectrum: bool = entry(
        "amplitudes over frequency, with a Hann window, not over time", default=False
    )
    against: Name | None = optional(
        "name of another signal, along the horizontal axis in place of time: an orbit, a loop"
    )

    @model_validator(mode="after")
    def _one_axis(self) -> "Figure":
        if self.spectrum and self.against:
            raise ValueError("expected either `spectrum` or `against`")
        return self


class CaseFile(Table):
    """Top-level keys of a case file, in addition to the keys of the mechanism."""

    format: Literal[1] = entry("version of this format")
    units: Unit = entry(MEANING, default="m")
    title: str = entry("one line")
    variants: dict[Name, dict[str, object]] = entry(
        "partial cases: tables that are merged into the case", default={}
    )
    coarse: dict[str, object] = entry(
        "a variant for quick checks (`make CASE COARSE=1`), sweeps and design included", default={}
    )
    runs: dict[Name, Run] = entry("what is computed", min_length=1)
    figures: dict[Name, Figure] = entry("pictures that compare runs", default={})
    sweeps: dict[Name, Sweep] = entry("runs varied by numbers", default={})
    design: Design | None = optional("parameters of the design and studies")


RIGID = 13  # coordinates and velocities of a body without modes, kept at each output


def output_findings(mechanism: Mechanism) -> list[str]:
    """Return what is wrong with the outputs that a mechanism asks for, one line each."""
    solver = mechanism.solver
    key = f"solver.output_step = {solver.output_step:g}"
    if solver.output_step > solver.t_end:
        return [f"{key}: expected at most solver.t_end = {solver.t_end:g} s"]
    count = solver.t_end / solver.output_step
    if count <= solver.most_outputs:
        return []
    modes = sum(
        getattr(mode, "count", 1)
        for body in mechanism.bodies.values()
        if isinstance(body, BeamBody | ShellBody | SolidBody)
        for mode in body.modes
    )
    width = RIGID * len(mechanism.bodies) + 2 * modes
    size = f"{8.0 * width * count:.3g}" if isfinite(count) else "more than 1e308"
    return [
        f"{key}: {count:.4g} outputs up to t_end = {solver.t_end:g} s, which take at least {size} "
        f"bytes; expected at most solver.most_outputs = {solver.most_outputs}, which may be raised"
    ]


def mechanism_of(
    table: dict[str, object], folder: Path, units: str = "m"
) -> tuple[Mechanism, dict[str, str]]:
    """Return a mechanism as a user wrote it, and the texts at dotted keys in place of numbers.

    Parameters
    ----------
    folder : of the case file
    units : of its lengths; those of the mechanism are in metres

    Raises
    ------
    ValidationError
        A text that is no expression of `[parameters]` is an error like any other wrong value.
    """
    given = table.get("parameters")
    numbers = dict(given) if isinstance(given, dict) else {}
    texts: dict[str, str] = {}
    context = {FOLDER: folder, UNITS: units}
    while True:
        try:
            return Mechanism.model_validate(table, context=context), texts
        except ValidationError as error:
            values = {}
            for item in error.errors():
                if item["type"] in ("float_type", "int_type") and isinstance(item["input"], str):
                    key = ".".join(map(str, follow(Mechanism, item["loc"])[0]))
                    value = number_of(item["input"], numbers)
                    if value is not None and not key.startswith("parameters."):
                        values[key], texts[key] = value, item["input"]
            if not values:
                raise _explained(error, numbers) from None
            try:
                table = put(table, values)
            except (LookupError, TypeError, ValueError):  # a text that stands for a whole table
                raise error from None


def _explained(error: ValidationError, numbers: Mapping[str, Any]) -> ValidationError:
    """Return the error; a text in place of a number says why it is no expression."""
    items: list[InitErrorDetails] = []
    for item in error.errors():
        kind: Any = item["type"]
        if kind in ("float_type", "int_type") and isinstance(item["input"], str):
            try:
                parsed(item["input"], Plain({k: 0.0 for k in numbers}))
            except ExpressionError as wrong:
                kind = PydanticCustomError(kind, item["msg"], {"why": f": {wrong}"})
        items.append(
            InitErrorDetails(
                type=kind, loc=item["loc"], input=item["input"], ctx=item.get("ctx", {})
            )
        )
    return ValidationError.from_exception_data(error.title, items)


def number_of(text: str, parameters: Mapping[str, Any]) -> float | None:
    """Return the value of an expression of numbers by name; None for another text."""
    if is_number(text):
        return None  # a number in quotes
    try:
        with np.errstate(all="ignore"):
            tree = parsed(text, Plain({k: float(v) for k, v in parameters.items()}))
            value = None if any(leaf.code == TIME for leaf in tree.leaves()) else value_at(tree)
    except (ArithmeticError, ValueError, TypeError):
        return None
    if value is None or not isfinite(value):
        return None
    return int(value) if value == int(value) else value


def resolved(table: Mapping[str, Any], where: str) -> Mechanism:
    """Return the mechanism of a run or sweep file, as `check` wrote it.

    Raises
    ------
    InputError
        A file that was not written by `check`, or by another version; `where` names it.
    """
    mechanism = validated(Mechanism, table, where, **{RESOLVED: True})
    if wrong := output_findings(mechanism):
        raise InputError("\n".join(f"{where}: {line}" for line in wrong))
    return mechanism


def split_key(key: str) -> list[str]:
    """Return the parts of a dotted key of a case.

    After a colon it is a key of a description: "sections.tube:laminates.wall.angles_deg.1" is
    the change "laminates.wall.angles_deg.1" of the table sections.tube.
    """
    owner, colon, inner = key.partition(":")
    return [*owner.split("."), *(["changes", inner] if colon else [])]


def put(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, object]:
    """Return plain data with other values at dotted keys; numbers are places of lists.

    What does not change is shared with `table`.
    """
    changed = dict(table)
    for key, value in changes.items():
        here: Any = changed
        *way, last = split_key(key)
        for part in way:
            place: Any = int(part) if isinstance(here, list) else part
            here[place] = copy(here[place])
            here = here[place]
        here[int(last) if isinstance(here, list) else last] = value
    return changed


def changed_mechanism(mechanism: Mechanism, changes: Mapping[str, Any]) -> Mechanism:
    """Return a mechanism with other values at dotted keys, checked like one from a file."""
    return resolved(put(mechanism.model_dump(), changes), "changed mechanism")
