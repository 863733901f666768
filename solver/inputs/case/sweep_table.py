"""Content of build/<case>/sweeps/<name>.json, the input of the solver for a sweep."""

from typing import Any

from .sweep_keys import differences
from .sweep_members import CheckedSweep

Packages = dict[str, dict[str, str]]


def sweep_content(
    case: str, name: str, sweep: CheckedSweep, packages: list[Packages]
) -> dict[str, Any]:
    """Return the content of the file.

    A member is the mechanism with `changes` (dotted keys) and its own `packages`, given by their
    numbers in the list of all; `values` are those of the parameters.

    Parameters
    ----------
    packages : of every member: file and hash of the inputs by body
    """
    numbers: dict[tuple[tuple[str, str], ...], int] = {}
    base = sweep.base.model_dump()
    members = []
    for values, member, table in zip(sweep.points, sweep.members, packages, strict=True):
        own = {
            body: numbers.setdefault(tuple(sorted(entry.items())), len(numbers))
            for body, entry in table.items()
        }
        changes = dict(differences(base, member.model_dump()))
        members.append({"values": values.tolist(), "changes": changes, "packages": own})
    said = sweep.table
    return {
        "case": case,
        "sweep": name,
        "title": said.title or name,
        "run": said.run,
        "design": said.design,
        "parameters": [{"name": p.name, "keys": p.keys, "unit": p.unit} for p in sweep.parameters],
        "signals": said.signals or list(sweep.base.signals),
        "histories": said.histories,
        "packages": [dict(entry) for entry in numbers],
        "mechanism": base,
        "members": members,
    }
