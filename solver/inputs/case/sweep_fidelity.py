"""A sweep of a run with [fidelity]: packages of its base, members at which it is checked."""

import hashlib
import json
import random
from collections.abc import Callable
from typing import Any

from .body_specs import BodySpec
from .rich import model_and_check
from .schema import Mechanism
from .sweep_members import CheckedSweep

DRAWN = 3  # members at which the plan is checked
Files = Callable[[Mechanism, dict[str, BodySpec]], dict[str, dict[str, str]]]


def drawn_members(sweep: CheckedSweep) -> list[int]:
    """Return the numbers of members drawn at random; the same sweep always has the same."""
    fidelity = sweep.base.fidelity
    said = fidelity.model_dump() if fidelity is not None else None
    text = json.dumps([said, sweep.points.tolist(), sweep.table.vary], default=str)
    seed = hashlib.sha256(text.encode()).hexdigest()
    count = len(sweep.members)
    return sorted(random.Random(seed).sample(range(count), min(DRAWN, count)))


def with_fidelity(sweep: CheckedSweep, content: dict[str, Any], files: Files) -> dict[str, Any]:
    """Return the content of a sweep file with the key `fidelity`, if the run has [fidelity].

    `files` gives the packages of a mechanism by its specifications. `base` and `base_check` are
    numbers of those of the run without changes, `drawn` has those of the check at some members.
    """
    if sweep.base.fidelity is None:
        return content
    packages = list(content["packages"])

    def numbers(mechanism: Mechanism, specs: dict[str, BodySpec]) -> dict[str, int]:
        found = {}
        for body, entry in files(mechanism, specs).items():
            if entry not in packages:
                packages.append(entry)
            found[body] = packages.index(entry)
        return found

    model, check = model_and_check(sweep.base_bodies)
    table = {
        "base": numbers(sweep.divided, model),
        "base_check": numbers(sweep.divided, check),
        "drawn": [
            {"member": k, "check": numbers(sweep.members[k], model_and_check(sweep.bodies[k])[1])}
            for k in drawn_members(sweep)
        ],
    }
    return {**content, "fidelity": table, "packages": packages}
