"""The members of a sweep: every point of its design as a checked mechanism."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from ....errors import InputError, unknown
from ....math.arrays import Array
from ...common.messages import bare_lines, validated
from ..bodies.body_specs import BodySpec, BodySpecs
from ..checks.check import in_parts
from ..tables.columns import FOLDER, RESOLVED
from ..tables.combining import needed, with_parts
from ..tables.dotted_keys import put
from ..tables.schema import Mechanism
from ..tables.sweeps import Sweep
from .sweep_keys import Misplaced, Parameter, changes_of, parameters_of, unit_at

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


def check_sweep(
    where: str,
    sweep: Sweep,
    specs: BodySpecs,
    merged_of: Callable[[str], dict[str, Any] | None],
) -> CheckedSweep | list[str]:
    """Return the members of a sweep, or one line per finding.

    Parameters
    ----------
    where : file and key of the sweep
    specs : of the case
    merged_of : mechanism of a run by its name, as the user wrote it, with its variants and those
        of the sweep; None: there is no such run, which is said elsewhere
    """
    merged = merged_of(sweep.run)
    if merged is None:
        return []
    try:
        base = validated(Mechanism, merged, where, **{FOLDER: specs.folder})
    except InputError as error:
        return str(error).splitlines()
    _, base_bodies, wrong = in_parts(base, specs)
    found = [f"{where}: {line}" for line in wrong]
    for key in ("signals", "histories"):
        for name in getattr(sweep, key):
            found += unknown(f"{where}.{key}", name, "signal", base.signals)
    try:
        parameters = parameters_of(sweep, base, specs.folder)
    except Misplaced as error:
        return [*found, f"{where}.vary: {error}"]
    times = {"solver.t_end", "solver.output_step"}
    for parameter in parameters:
        if sweep.histories and times & set(parameter.keys):
            found.append(
                f"{where}.histories: expected none where {parameter.name} is varied: "
                "histories of all members need the same times"
            )
    if found:
        return found
    points, problems = sweep.points(), _MemberProblems(where)
    maker = _Maker(sweep, parameters, points, specs)
    own = maker.members(base, problems)
    others = dict[str, Members]()
    kept = with_parts({*sweep.signals, *sweep.histories} or set(base.signals), base.signals)
    for run in needed(kept):
        table = merged_of(run)
        if table is None:
            return []  # said of the run
        try:
            other = validated(Mechanism, table, where, **{FOLDER: specs.folder})
        except InputError:
            return []  # said of the run
        others[run] = maker.members(other, problems, partly=True)
    if problems.found:
        return problems.lines()
    return CheckedSweep(sweep, parameters, points, own, others, base_bodies)


@dataclass(frozen=True)
class _Maker:
    """Makes the members of runs."""

    sweep: Sweep
    parameters: list[Parameter]
    points: Array
    specs: BodySpecs

    def members(
        self, base: Mechanism, problems: "_MemberProblems", *, partly: bool = False
    ) -> Members:
        """Return the members of a run; `partly`: without changes of keys that it does not have."""
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
                found = changes_of(self.sweep, self.parameters, values, base.parameters)
                changes = {key: v for key, v in found.items() if key not in left_out}
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
            told = f"{line} (member {number}: {member})"
            key = re.split(" = |: ", line, maxsplit=1)[0]
            same = key + NUMBER.sub("", line.removeprefix(key))
            self.found.setdefault(same, []).append(told)

    def lines(self) -> list[str]:
        """Return one line per finding, with the first member that has it."""
        return [
            f"{self.where}: {told[0].removesuffix(')')}"
            + (f"; and {len(told) - 1} more members)" if len(told) > 1 else ")")
            for told in self.found.values()
        ]
