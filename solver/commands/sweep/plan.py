"""What a sweep computes: its members, their numbers and their packages."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from plymotion import __version__

from ...errors import InputError, PackageError
from ...inputs.case.dotted_keys import put
from ...inputs.case.resolved import resolved
from ...inputs.case.schema import Mechanism
from ...inputs.case.segments import in_segments
from ...inputs.case.sources import solver_sha256
from ...package import ModalPackage
from ...package.common.plain_data import data_sha256
from ...run.execution import package_of

ROWS = 2  # version of what is computed of a member: raised when its numbers change their meaning


@dataclass(frozen=True)
class Parameter:
    """What is varied."""

    name: str
    keys: tuple[str, ...]
    unit: str


@dataclass(frozen=True)
class Variant:
    """A run with changes."""

    changes: dict[str, Any]  # dotted keys of the mechanism
    packages: dict[str, int]  # body -> number in the list of packages


@dataclass(frozen=True)
class Member:
    """One point of the design."""

    values: tuple[float, ...]
    own: Variant
    other_runs: dict[str, Variant]  # that combined signals read
    number: int  # in the sweep


@dataclass(frozen=True)
class Plan:
    """A sweep as `check` wrote it."""

    file: Path
    case: str
    name: str
    title: str
    run: str
    design: str
    parameters: tuple[Parameter, ...]
    signals: tuple[str, ...]
    histories: tuple[str, ...]
    table: dict[str, Any]  # mechanism that all members change, as in the file
    mechanism: Mechanism  # the same
    other_runs: dict[str, dict[str, Any]]  # mechanisms of other runs, likewise
    packages: tuple[dict[str, str], ...]  # file, inputs_sha256
    members: tuple[Member, ...]
    fidelity: dict[str, Any] | None = None  # numbers of packages of the base and of checks
    allow_doubtful: bool = False  # as in `read_package`

    def part(self, members: Sequence[Member]) -> "Plan":
        """Return the same sweep with some of its members."""
        return replace(self, members=tuple(members))

    def mechanism_of(self, number: int) -> Mechanism:
        """Return the mechanism of one member. Raises InputError."""
        where = f"{self.file}: member {self.members[number].number}"
        return in_segments(resolved(self._table_of(number), where))

    def other_mechanism(self, number: int, run: str) -> Mechanism:
        """Return the mechanism of another run of one member. Raises InputError."""
        where = f"{self.file}: member {self.members[number].number}, run {run}"
        return in_segments(resolved(self._others_of(number)[run], where))

    def _table_of(self, number: int) -> dict[str, Any]:
        return put(self.table, self.members[number].own.changes)

    def _others_of(self, number: int) -> dict[str, dict[str, Any]]:
        others = self.members[number].other_runs
        return {run: put(self.other_runs[run], variant.changes) for run, variant in others.items()}

    def package_file(self, number: int) -> Path:
        """Return where a package lies."""
        return self.file.parent.parent / self.packages[number]["file"]

    def package(self, number: int) -> ModalPackage:
        """Read a package. Raises PackageError: unreadable, or built from other inputs."""
        entry = self.packages[number]
        whose = f"a member of sweep {self.name} of case {self.case}"
        return package_of(
            self.package_file(number),
            entry.get("inputs_sha256"),
            whose,
            "sweep",
            allow_doubtful=self.allow_doubtful,
        )

    @property
    def model_plan_file(self) -> Path:
        """Where the plan of a sweep with [fidelity] is."""
        return self.file.with_suffix(".plan.toml")

    def digest(self) -> str:
        """Return the hash of the members, their packages and the solver, without the plan."""
        members = [[member.values, member.own.changes] for member in self.members]
        contents = [_content(self.package_file(k)) for k in range(len(self.packages))]
        return data_sha256([__version__, solver_sha256(), self.table, members, contents])

    def keys(self) -> list[str]:
        """Return the hash of what each member's numbers depend on.

        Its mechanism, the content of its packages, what is kept, and the solver.
        """
        common = [ROWS, __version__, solver_sha256(), self.signals, self.histories]
        if self.fidelity is not None:
            common.append(_content(self.model_plan_file))
        contents = [_content(self.package_file(k)) for k in range(len(self.packages))]
        found = []
        for number, member in enumerate(self.members):
            used = [
                {body: contents[k] for body, k in variant.packages.items()}
                for variant in (member.own, *member.other_runs.values())
            ]
            tables = [self._table_of(number), self._others_of(number)]
            found.append(data_sha256([*common, *tables, used]))
        return found


def read_plan(file: Path, *, allow_doubtful: bool = False) -> Plan:
    """Read build/<case>/sweeps/<name>.json.

    Raises
    ------
    InputError
        Not such a file.
    PackageError
        None of its packages can be read; if only some are missing, members fail instead.
    """
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
        plan = Plan(
            file=file,
            case=table["case"],
            name=table["sweep"],
            title=table["title"],
            run=table["run"],
            design=table["design"],
            parameters=tuple(
                Parameter(p["name"], tuple(p["keys"]), p["unit"]) for p in table["parameters"]
            ),
            signals=tuple(table["signals"]),
            histories=tuple(table["histories"]),
            table=table["mechanism"],
            mechanism=resolved(table["mechanism"], str(file)),
            packages=tuple(table["packages"]),
            other_runs=table["other_runs"],
            members=tuple(
                Member(
                    tuple(m["values"]),
                    _variant(m),
                    {run: _variant(other) for run, other in m["other_runs"].items()},
                    number,
                )
                for number, m in enumerate(table["members"])
            ),
            fidelity=table.get("fidelity"),
            allow_doubtful=allow_doubtful,
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(
            f"{file}: not a sweep file ({error}); expected one written by `plymotion check`"
        ) from error
    if plan.packages and not any(plan.package_file(k).is_file() for k in range(len(plan.packages))):
        raise PackageError(
            f"{plan.package_file(0)}: no such file, nor any other package of the sweep: "
            f"`plymotion packages {file}` builds them"
        )
    return plan


def _variant(table: dict[str, Any]) -> Variant:
    return Variant(table["changes"], table["packages"])


def _content(file: Path) -> str:
    """Return the hash of a package's file, nothing if it is not there."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""
