"""The members of a sweep: every point of its design as a checked mechanism."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ValidationError

from ...errors import InputError, nearest, refuse, unknown
from ...math.arrays import Array
from ...math.expressions import operations as op
from ...math.expressions.parse import ExpressionError, Plain, parsed
from ...math.expressions.program import Node, value_at
from ..common.input_table import Table, bare_lines, lines, meant
from ..common.input_table import unit as unit_of
from ..common.text_file import Tables
from ..common.units import LENGTHS, in_metres
from .bodies.descriptions import described
from .bodies.specifications import BodySpec, BodySpecs
from .checks import in_parts
from .record import needed, with_parts
from .tables.kinds import ALONG, CURVE
from .tables.laws import RESOLVED
from .tables.schema import Mechanism, Sweep, mechanism_of, number_of, put

MergedOf = Callable[[str], Tables]


class Misplaced(Exception):
    """A dotted key that is not the key of a number; the message names its last existing part."""


@dataclass(frozen=True)
class Parameter:
    """What a sweep varies, found in the mechanism.

    Attributes
    ----------
    unit : of its values
    metres : of those of its keys that are lengths of the case: metres in the unit of the value
    """

    name: str
    keys: list[str]
    unit: str
    metres: dict[str, float]


def parameters_of(sweep: Sweep, mechanism: Mechanism, folder: Path, units: str) -> list[Parameter]:
    """Return the parameters with the keys that depend on them, and their units.

    Parameters
    ----------
    folder : of the case file
    units : of lengths in the case file

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
    found_units = {key: unit_at(mechanism, key, folder, units) for key in sweep.expressions}
    parameters = []
    for name, variation in sweep.vary.items():
        by_expression = [key for key, names in read.items() if name in names]
        own = variation.keys or ([] if by_expression else [name])
        for key in own:
            if key in owner:
                raise Misplaced(f"{key}: varied twice, by {owner[key]} and {name}")
            owner[key] = name
            found_units[key] = unit_at(mechanism, key, folder, units)
        keys = [*own, *by_expression]
        unit = variation.unit
        if unit is None:
            direct = own or [k for k in keys if sweep.expressions[k].strip(" -+") == name]
            known = {found_units[key] for key in direct}
            unit = known.pop() if len(known) == 1 else ""
        metres = {
            key: LENGTHS[unit if key in own and unit in LENGTHS else units]
            for key in keys
            if found_units[key] == units and ":" not in key
        }
        parameters.append(Parameter(name, keys, unit, metres))
    return parameters


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
    changes: dict[str, float] = {}
    for parameter in parameters:
        for key in parameter.keys:
            if key not in sweep.expressions:
                changes[key] = values[parameter.name]
    for key, text in sweep.expressions.items():
        try:
            with np.errstate(all="ignore"):
                value = value_at(parsed(text, Plain({**numbers, **values})))
        except (ArithmeticError, ExpressionError) as error:
            raise Misplaced(f'set."{key}" = "{text}": {error}') from error
        if not math.isfinite(value):
            raise Misplaced(f'set."{key}" = "{text}": expected a finite value')
        changes[key] = value
    for parameter in parameters:
        changes |= {key: changes[key] / (1.0 / metres) for key, metres in parameter.metres.items()}
    return {key: int(v) if v == int(v) else v for key, v in changes.items()}


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
        raise Misplaced(
            f'set."{key}" = "{text}": expected a parameter of `vary`{hint}; a number that no '
            f'member changes belongs in the case, or in `vary` with one value, "{key}" = [...]'
        )
    return names


def unit_at(mechanism: Mechanism, key: str, folder: Path, units: str = "m") -> str:
    """Return the unit of the number at a key in the file that has it, "" for none.

    See `number_at`.

    Parameters
    ----------
    mechanism : tables of the case, checked for types and bounds
    key : dotted key of a number of the case
    folder : folder for relative names of files
    units : unit of length of the case file
    """
    return number_at(mechanism, key, folder, units)[0]


def number_at(
    mechanism: Mechanism, key: str, folder: Path, units: str = "m", *, text: bool = False
) -> tuple[str, Any]:
    """Return unit and value of the number at a key of a case or of a description; None: absent.

    Parameters
    ----------
    units : of lengths in the case file
    text : of a text in place of a number

    Raises
    ------
    Misplaced
        A part of the key does not exist, or its value is not a number.
    """
    owner, colon, inner = key.partition(":")
    if not colon:
        return _number(mechanism, key, key, units, text=text)
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
    return _number(model, inner, key, getattr(model, "units", "m"), text=text)


def _number(model: BaseModel, key: str, shown: str, units: str, *, text: bool) -> tuple[str, Any]:
    """Return unit and value at a key below a model; `shown` is the key in messages."""
    here: Any = model
    unit, way, by_text = "", list[str](), False
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
            hint = "; `layup` is text: write angles_deg in its place" if by_text else ""
            raise Misplaced(f"{shown}: {'.'.join(way)} is absent in this run{hint}")
        else:
            raise Misplaced(f"{shown}: {'.'.join(way)} has no keys")
        way.append(part)
        if part not in known and "changes" in known:
            right = f"{'.'.join(parts[:number])}:{'.'.join(parts[number:])}"
            raise Misplaced(f'{shown}: a key of the description follows a colon, "{right}"')
        if part not in known and len(parts) == 1:
            raise Misplaced(
                f'{shown}: expected a dotted key, such as "bodies.arm.length", or `keys` with such '
                f"keys{nearest(part, known)}"
            )
        if part not in known:
            raise Misplaced(f"{shown}: unknown key {'.'.join(way)}{meant(part, known)}")
        if isinstance(here, BaseModel):
            unit = unit_of(type(here).model_fields[part])
            more = (*here.more_lengths, CURVE) if isinstance(here, Table) else ()
            apart = unit == ALONG or part in {each.partition(".")[0] for each in more}
            if units != "m" and apart:
                raise Misplaced(f'{shown}: is in {units} here; expected units = "m" to vary it')
            by_text = part == "angles_deg" and getattr(here, "layup", None) is not None
            here = getattr(here, part)
        else:
            if isinstance(here, list) and "," in unit:  # those of its entries, as text
                unit = ""
            here = here[int(part)] if isinstance(here, list) else here[part]
    kinds = str if text else int | float
    if here is not None and (isinstance(here, bool) or not isinstance(here, kinds)):
        known_kinds = {str: "text", bool: "true or false", list: "a list", dict: "a table"}
        what = known_kinds.get(type(here), "a number" if text else "a table")
        wanted = "a text" if text else "a number"
        raise Misplaced(f"{shown}: expected the key of {wanted}, this is {what}")
    return units if unit == "m" else unit, here


NUMBER = re.compile(r"-?\d+(\.\d*)?(e[-+]?\d+)?")


@dataclass(frozen=True)
class Members:
    """A run, and what each member of a sweep changes in it."""

    base: Mechanism
    changes: list[dict[str, float]]  # (k) values at dotted keys
    bodies: list[dict[str, BodySpec]]  # (k) specifications of their flexible bodies by name


@dataclass(frozen=True)
class CheckedSweep:
    """A sweep with checked members."""

    table: Sweep
    parameters: list[Parameter]
    points: Array  # (k, p)
    own: Members
    others: dict[str, Members]  # other runs that combined signals read
    base_bodies: dict[str, BodySpec]  # specifications of the flexible bodies of the base

    @property
    def base(self) -> Mechanism:
        """The run that is varied."""
        return self.own.base


def base_of(
    where: str, merged: dict[str, object], specs: BodySpecs
) -> tuple[Mechanism, dict[str, str]]:
    """Return `mechanism_of` a run that is varied. Raises InputError.

    Parameters
    ----------
    where : file and run, for messages
    merged : tables of the run
    specs : specifications of its bodies
    """
    try:
        return mechanism_of(merged, specs.folder, specs.units)
    except ValidationError as error:
        raise InputError("\n".join(lines(error, Mechanism, where))) from error


def check_sweep(
    where: str,
    sweep: Sweep,
    specs: BodySpecs,
    merged_of: MergedOf,
) -> CheckedSweep:
    """Return the members of a sweep.

    Parameters
    ----------
    where : file and key of the sweep
    specs : of the case
    merged_of : mechanism of a run of the case by its name, as the user wrote it, with its variants
        and those of the sweep

    Raises
    ------
    InputError
        One line per finding; none if all are said of another run that signals read.
    """
    base, texts = base_of(where, merged_of(sweep.run), specs)
    _, base_bodies, wrong = in_parts(base, specs)
    errors = [f"{where}: {line}" for line in wrong]
    for key in ("signals", "histories"):
        for name in getattr(sweep, key):
            errors += unknown(f"{where}.{key}", name, "signal", base.signals)
    try:
        parameters = parameters_of(sweep, base, specs.folder, specs.units)
    except Misplaced as error:
        raise InputError("\n".join([*errors, f"{where}.vary: {error}"])) from error
    times = {"solver.t_end", "solver.output_step"}
    for parameter in parameters:
        if sweep.histories and times & set(parameter.keys):
            errors.append(
                f"{where}.histories: expected none where {parameter.name} is varied: "
                "histories of all members need the same times"
            )
    refuse(errors)
    points, problems = sweep.points(), _MemberProblems(where)
    maker = _Maker(sweep, parameters, points, specs)
    own = maker.members(base, texts, problems)
    others = dict[str, Members]()
    kept = with_parts({*(sweep.signals or base.signals), *sweep.histories}, base.signals)
    for run in needed(kept):
        try:
            other, texts = mechanism_of(merged_of(run), specs.folder, specs.units)
        except (KeyError, ValidationError) as error:
            raise InputError("") from error  # said of the run
        others[run] = maker.members(other, texts, problems, partly=True)
    refuse(problems.lines())
    return CheckedSweep(sweep, parameters, points, own, others, base_bodies)


@dataclass(frozen=True)
class _Maker:
    """Makes the members of runs."""

    sweep: Sweep
    parameters: list[Parameter]
    points: Array
    specs: BodySpecs

    def members(
        self,
        base: Mechanism,
        texts: Mapping[str, str],
        problems: "_MemberProblems",
        *,
        partly: bool = False,
    ) -> Members:
        """Return the members of a run; `partly`: without changes of keys that it does not have.

        `texts` are expressions of parameters in place of numbers, which follow varied parameters.
        """
        table, members = base.model_dump(), Members(base, [], [])
        left_out = {
            key
            for parameter in self.parameters
            for key in parameter.keys
            if partly and not self._has(base, key)
        }
        for k, point in enumerate(self.points):
            values = dict(zip(self.sweep.vary, map(float, point), strict=True))
            try:
                complete = changes_of(self.sweep, self.parameters, values, base.parameters)
                changes = {key: v for key, v in complete.items() if key not in left_out}
                changes |= self._following(base, texts, changes)
                member = Mechanism.model_validate(put(table, changes), context={RESOLVED: True})
            except Misplaced as error:
                problems.add(k, values, [str(error)])
                continue
            except ValidationError as error:
                problems.add(k, values, bare_lines(error, Mechanism))
                continue
            _, bodies, wrong = in_parts(member, self.specs)
            problems.add(k, values, wrong)
            members.changes.append(changes)
            members.bodies.append(bodies)
        return members

    def _following(
        self, base: Mechanism, texts: Mapping[str, str], changes: Mapping[str, float]
    ) -> dict[str, float]:
        """Return the numbers that are expressions of parameters which a member changes."""
        own = {
            k.removeprefix("parameters."): v
            for k, v in changes.items()
            if k.startswith("parameters.")
        }
        values: dict[str, float] = {}
        for key, text in texts.items() if own else ():
            value = number_of(text, {**base.parameters, **own})
            if value is None:
                raise Misplaced(f'{key} = "{text}": expected a finite value')
            if key not in changes:
                is_length = unit_at(base, key, self.specs.folder) == "m"
                values[key] = in_metres(value, self.specs.units) if is_length else value
        return values

    def _has(self, mechanism: Mechanism, key: str) -> bool:
        try:
            unit_at(mechanism, key, self.specs.folder)
        except Misplaced:
            return False
        return True


class _MemberProblems:
    """Findings of the members of a sweep: those that differ in a value only are one."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.found: dict[str, list[str]] = {}  # finding without numbers: as it is, by member

    def add(self, number: int, values: dict[str, float], lines: list[str]) -> None:
        """Add the findings of a member."""
        member = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
        for line in lines:
            text = f"{line} (member {number}: {member})"
            key = re.split(" = |: ", line, maxsplit=1)[0]
            same = key + NUMBER.sub("", line.removeprefix(key))
            self.found.setdefault(same, []).append(text)

    def lines(self) -> list[str]:
        """Return one line per finding, with the first member that has it."""
        return [
            f"{self.where}: {texts[0].removesuffix(')')}"
            + (f"; and {len(texts) - 1} more members)" if len(texts) > 1 else ")")
            for texts in self.found.values()
        ]
