"""A case by its name, and its checked mechanism as plain data, without the models of the schema.

Commands that only run read this: no library is imported here.
"""

import hashlib
import json
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict, TypeVar, cast

from ...errors import InputError
from ...math.disk_cache import sources_sha256

if TYPE_CHECKING:
    from .tables.schema import Mechanism


CASE_FILE = "case.toml"
Item = TypeVar("Item")


class PackageEntry(TypedDict):
    """A package, as a run file has it."""

    file: str
    inputs_sha256: NotRequired[str]


def case_file(path: Path) -> Path:
    """Return a case file; of a folder, the case.toml in it."""
    return path / CASE_FILE if path.is_dir() else path


def case_name(file: Path) -> str:
    """Return the name of the folder of a case.toml; of another file its own."""
    if file.stem in (".", ".."):  # "...toml": build/.. would be the folder of its files
        raise InputError(f"{file}: expected a file with a name before its ending")
    return file.resolve().parent.name if file.name == CASE_FILE else file.stem


# Parts of solver/ that have no part in the motion of a mechanism.
_APART = (
    "solver/__main__.py",
    "solver/commands/",
    "solver/extras/",
    "solver/report/",
    "solver/workers/",
)


def solver_sha256() -> str:
    """Return the digest of the sources of the solver."""
    return sources_sha256("solver", apart=_APART)


KINDS = ("difference", "norm")
REACTION = "reaction"  # kind of the signals that are joint forces


def parts(signal: Any) -> list[str]:
    """Return the signals of its own run that a combined signal reads; none of another signal."""
    if signal.kind == "norm":
        return list(signal.of)
    if signal.kind != "difference":
        return []
    return [signal.of, *([signal.minus] if signal.minus and signal.run is None else [])]


def has_reaction(name: str, signals: Mapping[str, Any]) -> bool:
    """Whether a signal is a joint force, or combined of one."""
    signal = signals[name]
    return signal.kind == REACTION or any(has_reaction(part, signals) for part in parts(signal))


def elsewhere(signal: Any) -> list[str]:
    """Return the signals of its `run` that a combined signal reads."""
    if signal.kind not in KINDS or signal.run is None:
        return []
    return list(signal.of) if signal.kind == "norm" else [signal.minus or signal.of]


def needed(signals: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the other runs that signals read, with the names of what is read there."""
    by_run: dict[str, dict[str, None]] = {}
    for signal in signals.values():
        for name in elsewhere(signal):
            by_run.setdefault(signal.run, {})[name] = None
    return {run: list(names) for run, names in by_run.items()}


def with_parts(names: Collection[str], signals: Mapping[str, Item]) -> dict[str, Item]:
    """Return signals by name with all those that they read in the same run."""
    complete: dict[str, Item] = {}
    left = list(names)
    while left:
        name = left.pop()
        if name not in complete and name in signals:
            complete[name] = signals[name]
            left += parts(signals[name])
    return complete


def loaded_places(
    name: str, mechanism: "Mechanism", turning: Collection[str] | None = None
) -> list[str]:
    """Return the interfaces of a body where joints, force elements or masses act, each once.

    A force along the coordinate of a joint acts at the places of the joint.

    Parameters
    ----------
    name : of the body
    mechanism : whose joints, forces and masses act on it
    turning : kinds of force elements with a moment: those places only where moments may act
    """
    ends = [end for joint in mechanism.joints.values() for end in joint.between]
    ends += [mass.at for mass in mechanism.masses.values()] if turning is None else []
    for force in mechanism.forces.values():
        if turning is None or force.kind in turning:
            ends += getattr(force, "between", None) or [getattr(force, "at", None) or ""]
    places = [end.partition(".")[2] for end in ends if end.partition(".")[0] == name]
    return list(dict.fromkeys(places))


def package_entries(table: Mapping[str, Any]) -> Iterator[PackageEntry]:
    """Yield file and digest of all packages that a run needs, other runs included."""
    yield from table["packages"].values()
    yield from table.get("check_packages", {}).values()
    for other in table.get("other_runs", {}).values():
        yield from other["packages"].values()


class Record(SimpleNamespace):
    """A table as attributes, like a model of the schema; it must not be changed."""

    def model_dump(self) -> dict[str, object]:
        """Return plain data, as the model of the same name in pydantic does."""
        plain: dict[str, object] = _plain(self)
        return plain


def seal(mechanism: "Mechanism") -> dict[str, object]:
    """Return the record that a mechanism is checked: digest, and which tables have free keys."""
    named = sorted(_named(mechanism, ""))
    return {"named": named, "sha256": _digest(mechanism.model_dump(), named)}


def sealed(table: Mapping[str, Any], seal: Any) -> "Mechanism | None":
    """Return a mechanism from plain data whose seal is right, without checks; None otherwise."""
    named = seal.get("named") if isinstance(seal, dict) else None
    if not isinstance(named, list) or seal.get("sha256") != _digest(table, named):
        return None
    return cast("Mechanism", _record(table, "", frozenset(named)))


def _digest(table: Mapping[str, Any], named: list[str]) -> str:
    text = json.dumps([solver_sha256(), named, table], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _named(value: Any, path: str) -> list[str]:
    """Return the paths of all tables whose keys are names that the user gave."""
    if isinstance(value, dict):
        return [path, *(p for key, item in value.items() for p in _named(item, f"{path}/{key}"))]
    if isinstance(value, list):
        return [p for k, item in enumerate(value) for p in _named(item, f"{path}/{k}")]
    fields = getattr(type(value), "model_fields", ())
    return [p for name in fields for p in _named(getattr(value, name), f"{path}/{name}")]


def _record(value: Any, path: str, named: frozenset[str]) -> Any:
    if isinstance(value, list):
        return [_record(item, f"{path}/{k}", named) for k, item in enumerate(value)]
    if not isinstance(value, dict):
        return value
    items = {key: _record(item, f"{path}/{key}", named) for key, item in value.items()}
    return items if path in named else Record(**items)


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        value = vars(value)
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list) else value
