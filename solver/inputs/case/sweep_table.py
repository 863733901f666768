"""Content of build/<case>/sweeps/<name>.json, the input of the solver for a sweep."""

from typing import Any

from .sweep_keys import differences
from .sweep_members import CheckedSweep, Members

Packages = dict[str, dict[str, str]]


def sweep_content(
    case: str,
    name: str,
    sweep: CheckedSweep,
    packages: list[Packages],
    others: dict[str, list[Packages]],
) -> dict[str, Any]:
    """Return the content of the file.

    A member is the mechanism with `changes` (dotted keys) and its own `packages`, given by their
    numbers in the list of all; `values` are those of the parameters. `other_runs` are those that
    combined signals read, with the same changes.

    Parameters
    ----------
    packages : of every member: file and hash of the inputs by body
    others : the same of other runs
    """
    numbers: dict[tuple[tuple[str, str], ...], int] = {}

    def listed(members: Members, tables: list[Packages]) -> list[dict[str, Any]]:
        base = members.base.model_dump()
        return [
            {
                "changes": dict(differences(base, mechanism.model_dump())),
                "packages": {
                    body: numbers.setdefault(tuple(sorted(entry.items())), len(numbers))
                    for body, entry in table.items()
                },
            }
            for mechanism, table in zip(members.mechanisms, tables, strict=True)
        ]

    said = sweep.table
    own = listed(sweep.own, packages)
    elsewhere = {run: listed(sweep.others[run], tables) for run, tables in others.items()}
    return {
        "case": case,
        "sweep": name,
        "title": said.title or name,
        "run": said.run,
        "design": said.design,
        "parameters": [{"name": p.name, "keys": p.keys, "unit": p.unit} for p in sweep.parameters],
        "signals": said.signals or list(sweep.own.base.signals),
        "histories": said.histories,
        "mechanism": sweep.own.base.model_dump(),
        "other_runs": {run: sweep.others[run].base.model_dump() for run in others},
        "members": [
            {
                "values": values.tolist(),
                **member,
                "other_runs": {run: members[k] for run, members in elsewhere.items()},
            }
            for k, (values, member) in enumerate(zip(sweep.points, own, strict=True))
        ],
        "packages": [dict(entry) for entry in numbers],
    }
