"""The members of a sweep: every point of its design as a checked mechanism."""

from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from ...errors import nearest
from ...math.arrays import Array
from ..common import lines
from .body_specs import BodySpec, BodySpecs
from .check import cross_check
from .laws import FOLDER
from .parts import in_parts
from .schema import Mechanism
from .sharing import sharing
from .sweeps import Misplaced, Parameter, Sweep, changed, parameters_of

TOLD = 10  # limit of errors per sweep: hundreds of members may share one


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
        parameters = parameters_of(sweep, base)
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
    members, bodies, problems = [], list[dict[str, BodySpec]](), dict[str, None]()
    for values in points:
        changes = {
            key: float(value)
            for parameter, value in zip(parameters, values, strict=True)
            for key in parameter.keys
        }
        try:
            member = Mechanism.model_validate(changed(merged, defaults, changes), context=context)
        except ValidationError as error:
            problems |= dict.fromkeys(lines(error, Mechanism, where))
            continue
        divided, own, wrong = in_parts(member, specs)
        problems |= dict.fromkeys(f"{where}: {line}" for line in wrong)
        members.append(sharing(divided, base))
        bodies.append(own)
    if problems:
        more = [f"{where}: ... and {len(problems) - TOLD} more"] if len(problems) > TOLD else []
        return [*list(problems)[:TOLD], *more]
    return CheckedSweep(sweep, base, parameters, points, members, bodies)
