"""Content of build/<case>/sweeps/<name>.json, the input of the solver for a sweep."""

import hashlib
import json
import random
from collections.abc import Callable
from typing import Any

from ..bodies.body_specs import BodySpec
from ..bodies.rich import model_and_check
from .sweep_members import CheckedSweep, Members

DRAWN = 3  # members at which the plan is checked
Packages = dict[str, dict[str, str]]  # file and hash of the inputs by body
Files = Callable[[dict[str, BodySpec]], Packages]


def drawn_members(sweep: CheckedSweep) -> list[int]:
    """Return the numbers of members drawn at random; the same sweep always has the same."""
    fidelity = sweep.base.fidelity
    said = fidelity.model_dump() if fidelity is not None else None
    text = json.dumps([said, sweep.points.tolist(), sweep.table.vary], default=str)
    seed = hashlib.sha256(text.encode()).hexdigest()
    count = len(sweep.points)
    return sorted(random.Random(seed).sample(range(count), min(DRAWN, count)))


def with_fidelity(sweep: CheckedSweep, content: dict[str, Any], files: Files) -> dict[str, Any]:
    """Return the content of a sweep file with the key `fidelity`, if the run has [fidelity].

    `files` gives packages by their specifications. `base` and `base_check` are numbers of those of
    the run without changes, `drawn` has those of the check at some members.
    """
    if sweep.base.fidelity is None:
        return content
    packages = list(content["packages"])

    def numbers(specs: dict[str, BodySpec]) -> dict[str, int]:
        found = {}
        for body, entry in files(specs).items():
            if entry not in packages:
                packages.append(entry)
            found[body] = packages.index(entry)
        return found

    model, check = model_and_check(sweep.base_bodies)
    table = {
        "base": numbers(model),
        "base_check": numbers(check),
        "drawn": [
            {"member": k, "check": numbers(model_and_check(sweep.own.bodies[k])[1])}
            for k in drawn_members(sweep)
        ],
    }
    return {**content, "fidelity": table, "packages": packages}


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
        return [
            {
                "changes": changes,
                "packages": {
                    body: numbers.setdefault(tuple(sorted(entry.items())), len(numbers))
                    for body, entry in table.items()
                },
            }
            for changes, table in zip(members.changes, tables, strict=True)
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
