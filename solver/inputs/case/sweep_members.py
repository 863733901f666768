"""The members of a sweep: every point of its design as a checked mechanism."""

import re
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from ...errors import nearest
from ...math.arrays import Array
from ..common import lines
from ..common.messages import bare_lines
from .body_specs import BodySpec, BodySpecs
from .check import cross_check
from .laws import FOLDER
from .parts import in_parts
from .schema import Mechanism
from .sweep_keys import Misplaced, Parameter, changed, changes_of, parameters_of
from .sweeps import Sweep

VALUE = re.compile(r" = .*?(?=: )")  # of a key in a message


@dataclass(frozen=True)
class CheckedSweep:
    """A sweep with checked members."""

    table: Sweep
    base: Mechanism
    parameters: list[Parameter]
    points: Array  # (k, p)
    members: list[Mechanism]  # (k)
    bodies: list[dict[str, BodySpec]]  # (k) specifications of their flexible bodies by name


def check_sweep(
    where: str, sweep: Sweep, merged: dict[str, Any], specs: BodySpecs
) -> CheckedSweep | list[str]:
    """Return the members of a sweep, or one line per finding.

    Parameters
    ----------
    where : file and key of the sweep
    merged : mechanism as the user wrote it, variants applied
    specs : of the case
    """
    context = {FOLDER: specs.folder}
    try:
        base = Mechanism.model_validate(merged, context=context)
    except ValidationError as error:
        return lines(error, Mechanism, where)
    found = [f"{where}: {line}" for line in cross_check(base, specs)[1]]
    for key in ("signals", "histories"):
        for name in getattr(sweep, key):
            if name not in base.signals:
                hint = nearest(name, base.signals)
                found.append(f'{where}.{key} = "{name}": no such signal{hint}')
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
    points = sweep.points()
    defaults = base.model_dump()
    members, bodies, problems = [], list[dict[str, BodySpec]](), _MemberProblems(where)
    for k, point in enumerate(points):
        values = dict(zip(sweep.vary, map(float, point), strict=True))
        try:
            changes = changes_of(sweep, parameters, values, base.parameters)
            table = changed(merged, defaults, changes)
            member = Mechanism.model_validate(table, context=context)
        except Misplaced as error:
            problems.add(k, values, [str(error)])
            continue
        except ValidationError as error:
            problems.add(k, values, bare_lines(error, Mechanism))
            continue
        divided, own, wrong = in_parts(member, specs)
        problems.add(k, values, wrong)
        members.append(divided)
        bodies.append(own)
    if problems.found:
        return problems.lines()
    return CheckedSweep(sweep, base, parameters, points, members, bodies)


class _MemberProblems:
    """Findings of the members of a sweep: those that differ in a value only are one."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.found: dict[str, list[str]] = {}  # finding without value: as it is, by member

    def add(self, number: int, values: dict[str, float], lines: list[str]) -> None:
        """Add the findings of a member."""
        member = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
        for line in lines:
            told = f"{line} (member {number}: {member})"
            self.found.setdefault(VALUE.sub("", line), []).append(told)

    def lines(self) -> list[str]:
        """Return one line per finding, with the first member that has it."""
        return [
            f"{self.where}: {told[0].removesuffix(')')}"
            + (f"; and {len(told) - 1} more members)" if len(told) > 1 else ")")
            for told in self.found.values()
        ]
