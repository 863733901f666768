"""The checked mechanism of a run as plain data in a file, without the models that check it."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

from ..sources import solver_sha256

if TYPE_CHECKING:
    from .schema import Mechanism


def package_entries(table: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield file and digest of all packages that a run needs, other runs included."""
    yield from table["packages"].values()
    yield from table.get("check_packages", {}).values()
    for other in table.get("other_runs", {}).values():
        yield from other["packages"].values()


class Record(SimpleNamespace):
    """A table as attributes, like a model of the schema; it must not be changed."""

    def model_dump(self) -> dict[str, Any]:
        """Return plain data, as the model of the same name in pydantic does."""
        plain: dict[str, Any] = _plain(self)
        return plain


def seal(mechanism: "Mechanism") -> dict[str, Any]:
    """Return what tells that a mechanism is checked: digest, and which tables have free keys."""
    named = sorted(_named(mechanism, ""))
    return {"named": named, "sha256": _digest(mechanism.model_dump(), named)}


def sealed(table: Mapping[str, Any], found: Any) -> "Mechanism | None":
    """Return a mechanism from plain data whose seal is right, without checks; None otherwise."""
    named = found.get("named") if isinstance(found, dict) else None
    if not isinstance(named, list) or found.get("sha256") != _digest(table, named):
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
