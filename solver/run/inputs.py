"""A run with its packages, and what its result depends on: run file, packages, sources."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..inputs.case.record import package_entries, solver_sha256
from ..math.records import record
from ..package import ModalPackage
from ..package.common.design import moved
from ..package.common.files import has_right_seal
from ..results import ResultError, Summary, read_summary

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Fidelity, Mechanism


@record
class RunSpec:
    """A run as `check` wrote it, with its packages read.

    Attributes
    ----------
    other_runs : those that its combined signals read, by name
    units : of lengths in the case file, for messages with values to give there
    """

    case: str
    run: str
    mechanism: "Mechanism"
    packages: dict[str, ModalPackage]
    other_runs: dict[str, "RunSpec"] = field(default_factory=dict)
    units: str = "m"

    @property
    def fidelity(self) -> "Fidelity":
        """What a run with `[fidelity]` asks for."""
        assert self.mechanism.fidelity is not None
        return self.mechanism.fidelity

    def moved(self, name: str, step: float) -> "RunSpec":
        """Return the run with packages moved along their derivatives by a design parameter."""
        packages = {
            body: moved(package, {name: step})
            if any(one.name == name for one in package.design)
            else package
            for body, package in self.packages.items()
        }
        return replace(self, packages=packages)

    def changed(self, changes: Mapping[str, Any]) -> "RunSpec":
        """Return the run with other values at dotted keys of its mechanism, checked as a file is.

        Numbers that the case has as expressions of `[parameters]` are numbers here: a change of
        `parameters.NAME` is one of laws alone. `Case.changed` and sweeps make all of them follow.

        Raises
        ------
        InputError
            Values that a run file may not have.
        """
        from ..inputs.case.tables.schema import changed_mechanism  # a run does without the models

        return replace(self, mechanism=changed_mechanism(self.mechanism, changes))


def inputs_sha256(file: Path) -> str:
    """Return the digest of all that the result of a run depends on; "" if a part is missing."""
    try:
        content = file.read_bytes()
        digest = hashlib.sha256(solver_sha256().encode() + content)
        table = json.loads(content)
        packages = [file.parent.parent / entry["file"] for entry in package_entries(table)]
        if not all(package.is_file() for package in packages):  # a pipe would be waited for
            return ""
        for package in packages:
            digest.update(package.read_bytes())
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return ""
    return digest.hexdigest()


def still(file: Path, digest: str) -> str:
    """Return the digest of inputs that were read since it was computed; "" if they have changed.

    Then it is not known what was read, and the result is up to date with nothing.
    """
    return digest if inputs_sha256(file) == digest else ""


def plan_file(file: Path) -> Path:
    """Return where the plan of a run file with `[fidelity]` is."""
    return file.parent.parent / "plans" / f"{file.stem}.toml"


def plan_sha256(plan: Path) -> str:
    """Return the digest of what a plan says, without remarks and inputs; "" if it is no plan."""
    try:
        return text_sha256(plan.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return ""


def text_sha256(plan: str) -> str:
    """Return the digest of the text of a plan; see `plan_sha256`."""
    import tomllib  # most runs have no plan

    table = tomllib.loads(plan)
    table.pop("inputs_sha256", None)
    return hashlib.sha256(json.dumps(table, sort_keys=True, default=str).encode()).hexdigest()


def up_to_date(file: Path, out: Path) -> Summary | None:
    """Return the summary of a result that was not interrupted and has the inputs of a run file.

    The plan of a run with `[fidelity]`, which may be edited, is one of them.
    """
    try:
        summary = read_summary(out / "summary.json")
    except ResultError:
        return None
    there = has_right_seal(out / "result.vtkhdf") and summary.get("status") != "interrupted"
    known = summary.get("inputs_sha256")
    if not (there and known and known == inputs_sha256(file)):
        return None
    planned = summary.get("fidelity")
    if planned and planned.get("plan_sha256") != plan_sha256(plan_file(file)):
        return None
    return summary
