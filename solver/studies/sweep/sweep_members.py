"""What a sweep computes: its members, their numbers and their packages."""

import hashlib
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated

from pydantic import Field, PrivateAttr, ValidationError

from plymotion import __version__

from ...errors import InputError, PackageError, nearest, not_by_check
from ...inputs.case.bodies.segments import in_segments
from ...inputs.case.record import solver_sha256
from ...inputs.case.tables.schema import Mechanism, put, resolved
from ...inputs.common.input_table import FilePath, Name, Table, bare_lines
from ...package import ModalPackage
from ...package.common.plain_data import data_sha256
from ...run.execution import package_of

Number = Annotated[int, Field(ge=0)]  # in a list of the file
ROWS = 2  # version of what is computed of a member: raised when its numbers change their meaning


class Parameter(Table):
    """What is varied."""

    name: str
    keys: list[str]
    unit: str


class Variant(Table):
    """A run with changes."""

    changes: dict[str, object]  # dotted keys of the mechanism
    packages: dict[str, Number]  # body -> number in the list of packages


class Member(Variant):
    """One point of the design."""

    values: Annotated[tuple[float, ...], Field(strict=False)]  # of a list in JSON
    other_runs: dict[str, Variant]  # that combined signals read
    number: Number = 0  # in the sweep


class _Package(Table):
    file: FilePath
    inputs_sha256: str | None = None


class _Drawn(Table):
    member: Number
    check: dict[str, Number]


class _Fidelity(Table):
    base: dict[str, Number]
    base_check: dict[str, Number]
    drawn: list[_Drawn]


class SweepSpec(Table):
    """A sweep as `check` wrote it: build/<case>/sweeps/<name>.json, by sweep_table.py of inputs."""

    case: str
    name: Name = Field(alias="sweep")
    title: str
    run: str
    design: str
    parameters: list[Parameter]
    signals: list[str]
    histories: list[str]
    table: dict[str, object] = Field(alias="mechanism")  # that all members change
    other_runs: dict[str, dict[str, object]]  # mechanisms of other runs, likewise
    members: list[Member]
    packages: list[_Package]
    fidelity: _Fidelity | None = None

    _file: Path = PrivateAttr()
    _allow_doubtful: bool = PrivateAttr()  # as in `read_package`

    @property
    def file(self) -> Path:
        """The sweep file."""
        return self._file

    @property
    def allow_doubtful(self) -> bool:
        """Whether packages are used whose numbers contradict each other."""
        return self._allow_doubtful

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism that all members change."""
        return resolved(self.table, str(self.file))

    @property
    def base(self) -> Mechanism:
        """The run that members change, in the bodies that are built."""
        return in_segments(self.mechanism)

    def part(self, members: Sequence[Member]) -> "SweepSpec":
        """Return the same sweep with some of its members."""
        return self.model_copy(update={"members": list(members)})

    def mechanism_of(self, number: int, run: str | None = None) -> Mechanism:
        """Return the mechanism of one member, or of another run of it. Raises InputError."""
        where = f"{self.file}: member {self.members[number].number}"
        where += f", run {run}" if run is not None else ""
        return in_segments(resolved(self._tables(number)[run], where))

    def _tables(self, number: int) -> dict[str | None, dict[str, object]]:
        """Return the tables of one member, None, and of its other runs by name."""
        member, tables = self.members[number], dict[str | None, dict[str, object]]()
        tables[None] = put(self.table, member.changes)
        for run, variant in member.other_runs.items():
            tables[run] = put(self.other_runs[run], variant.changes)
        return tables

    def package_file(self, number: int) -> Path:
        """Return where a package lies."""
        return self.file.parent.parent / self.packages[number].file

    def package(self, number: int) -> ModalPackage:
        """Read a package. Raises PackageError: unreadable, or built from other inputs."""
        whose = f"a member of sweep {self.name} of case {self.case}"
        return package_of(
            self.package_file(number),
            self.packages[number].inputs_sha256,
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
        members = [[member.values, member.changes] for member in self.members]
        return data_sha256([__version__, solver_sha256(), self.table, members, self._contents()])

    def _contents(self) -> list[str]:
        """Return the hashes of the files of the packages."""
        return [_content(self.package_file(k)) for k in range(len(self.packages))]

    def keys(self) -> list[str]:
        """Return the hash of what each member's numbers depend on.

        Its mechanism, the content of its packages, what is kept, and the solver.
        """
        common = [ROWS, __version__, solver_sha256(), self.signals, self.histories]
        if self.fidelity is not None:
            common.append(_content(self.model_plan_file))
        contents, digests = self._contents(), []
        for number, member in enumerate(self.members):
            used = [
                {body: contents[k] for body, k in variant.packages.items()}
                for variant in (member, *member.other_runs.values())
            ]
            digests.append(data_sha256([*common, [*self._tables(number).items()], used]))
        return digests

    def check_numbers(self) -> None:
        """Raise ValueError: lengths or numbers that do not fit each other."""
        named: list[tuple[str, Mapping[str, int]]] = []
        for k, member in enumerate(self.members):
            if len(member.values) != len(self.parameters):
                raise ValueError(
                    f"members.{k}.values: expected {len(self.parameters)} numbers, those of the "
                    f"parameters, found {len(member.values)}"
                )
            variants = (member, *member.other_runs.values())
            named += [(f"members.{k}.packages", variant.packages) for variant in variants]
            if unknown := member.other_runs.keys() - self.other_runs.keys():
                raise ValueError(
                    f"members.{k}.other_runs.{min(unknown)}: no such run in other_runs"
                )
        if (fidelity := self.fidelity) is not None:
            named += [
                ("fidelity.base", fidelity.base),
                ("fidelity.base_check", fidelity.base_check),
            ]
            for k, drawn in enumerate(fidelity.drawn):
                named.append((f"fidelity.drawn.{k}.check", drawn.check))
                if drawn.member >= len(self.members):
                    raise ValueError(f"fidelity.drawn.{k}.member = {drawn.member}: no such member")
        for key, packages in named:
            for body, number in packages.items():
                if number >= len(self.packages):
                    raise ValueError(f"{key}.{body} = {number}: no such package")


def read_sweep_spec(file: Path, *, allow_doubtful: bool = False) -> SweepSpec:
    """Read build/<case>/sweeps/<name>.json.

    Raises
    ------
    InputError
        Not such a file.
    PackageError
        None of its packages can be read; if only some are missing, members fail instead.
    """
    try:
        sweep = SweepSpec.model_validate_json(file.read_bytes())
        sweep.check_numbers()
    except (OSError, ValueError, RecursionError) as error:
        reason = str(error)
        if isinstance(error, ValidationError):
            reason = "; ".join(bare_lines(error, SweepSpec)[:3])
        raise not_by_check(file, "sweep file", reason) from error
    members = [m.model_copy(update={"number": k}) for k, m in enumerate(sweep.members)]
    sweep = sweep.part(members)
    sweep._file, sweep._allow_doubtful = file, allow_doubtful
    for key in ("signals", "histories"):
        for name in getattr(sweep, key):
            if name not in sweep.mechanism.signals:
                hint = nearest(name, sweep.mechanism.signals)
                raise InputError(f'{file}: {key} = "{name}": no such signal{hint}')
    if sweep.packages and not any(
        sweep.package_file(k).is_file() for k in range(len(sweep.packages))
    ):
        raise PackageError(
            f"{sweep.package_file(0)}: no such file, nor any other package of the sweep: "
            f"`plymotion packages {file}` builds them"
        )
    return sweep


def _content(file: Path) -> str:
    """Return the hash of a package's file, nothing if it is not there."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""


class Packages:
    """Packages of a plan, each read once; one that cannot be read fails its members."""

    def __init__(self, sweep: SweepSpec) -> None:
        self.sweep = sweep
        self._known: dict[int, ModalPackage | PackageError] = {}

    def named(self, numbers: Mapping[str, int]) -> dict[str, ModalPackage]:
        """Return packages by body, given by their numbers in the plan. Raises PackageError."""
        packages = {}
        for body, k in numbers.items():
            if k not in self._known:
                try:
                    self._known[k] = self.sweep.package(k)
                except PackageError as error:
                    self._known[k] = error
            package = self._known[k]
            if isinstance(package, PackageError):
                raise PackageError(str(package))
            packages[body] = package
        return packages
