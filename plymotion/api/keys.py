"""Keys of a case as attributes, checked by the tables that check a case file."""

import re
from collections.abc import Iterator, Mapping, MutableMapping, MutableSequence
from copy import deepcopy
from pathlib import Path
from typing import Any, get_args, get_origin

from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic_core import PydanticUndefined

from ..solver.errors import InputError, nearest
from ..solver.inputs.case.tables.laws import FOLDER
from ..solver.inputs.case.tables.schema import CaseFile, Mechanism
from ..solver.inputs.common.input_table import Name, bare_lines, members, without_annotations
from ..solver.inputs.common.text_file import Tables
from ..solver.inputs.section.description import shape
from ..solver.package.common.plain_data import plain


class UnknownKey(AttributeError, InputError):
    """A key that a table does not have; the message has the nearest one that it does."""


def kind_of(key: str) -> Any:
    """Return the type of a key of a case file; a variant is a part of a mechanism."""
    partial = {"variants": dict[Name, Mechanism], "coarse": Mechanism}
    return partial.get(key) or model_of(key).model_fields[key].annotation


def model_of(key: str) -> type[BaseModel]:
    """Return the table that has a key of a case file."""
    return CaseFile if key in CaseFile.model_fields else Mechanism


class Keys(MutableMapping[str, Any]):
    """A table of a case: keys are items and attributes.

    An attribute is checked when it is set, as in a case file; an item is checked with the case.
    `dir` lists the keys that the table may have. A key that is absent reads as its default.

    Parameters
    ----------
    kind : type of the table: a model, or a dict of named tables
    where : its key in the case, and `name` in the table above
    above : the table above, to which this one is added with its first key

    Examples
    --------
    >>> import plymotion as pm
    >>> case = pm.load("pendulum.toml")
    >>> case.solver.rtol = 1e-4
    >>> case.bodies.rod.mass, "integrator" in dir(case.solver)
    (2.0, True)
    >>> case.solver.rtoll = 1e-4
    Traceback (most recent call last):
    plymotion.api.keys.UnknownKey: solver.rtoll: unknown key; did you mean 'rtol'?
    """

    __slots__ = ("_above", "_folder", "_kind", "_name", "_where")

    def __init__(self, kind: Any, where: str, name: str, above: Any, folder: Path) -> None:
        for slot, value in zip(self.__slots__, (above, folder, kind, name, where), strict=True):
            object.__setattr__(self, slot, value)

    @property
    def _table(self) -> Tables:
        value = self._above.get(self._name)
        return value if isinstance(value, dict) else {}

    def _stored(self) -> Tables:
        """Return the table to write into, added to that above if it is absent."""
        above = self._above if isinstance(self._above, dict) else self._above._stored()
        table: Tables = above.setdefault(self._name, {})
        return table

    @property
    def _model(self) -> type[BaseModel] | None:
        """The model of the table; None: named tables, or a kind that is not given yet."""
        kind, table = without_annotations(self._kind), self._table
        if named := members(kind):
            tags = (table.get("kind"), shape(table))
            return next((model for tag, model in named.items() if tag in tags), None)
        return kind if isinstance(kind, type) and issubclass(kind, BaseModel) else None

    def _kinds(self) -> dict[str, object]:
        """Return the type of each key that the table may have."""
        if get_origin(kind := without_annotations(self._kind)) is dict:
            return dict.fromkeys(self._table, get_args(kind)[1])
        models = [self._model] if self._model else list(members(kind).values())
        return {
            field.alias or name: field.annotation
            for model in models
            for name, field in model.model_fields.items()
        }

    def __getitem__(self, key: str) -> Any:
        return self._shown(key, self._table[key])

    def _shown(self, key: str, value: Any) -> Any:
        kind = self._kinds().get(key)
        if isinstance(value, dict):
            return Keys(kind, f"{self._where}.{key}", key, self, self._folder)
        if isinstance(value, list) and any(isinstance(item, dict) for item in value):
            inner = without_annotations(kind)
            one = get_args(inner)[0] if get_origin(inner) is list else None
            return Items(one, f"{self._where}.{key}", value, self._folder)
        return value

    def __setitem__(self, key: str, value: Any) -> None:
        self._stored()[key] = raw(value)

    def __delitem__(self, key: str) -> None:
        del self._table[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._table)

    def __len__(self) -> int:
        return len(self._table)

    def get(self, key: str, default: Any = None) -> Any:
        """Return what the table itself has at a key."""
        return self._table.get(key, default)

    def __getattr__(self, key: str) -> Any:
        if key in self._table:
            return self[key]
        if key.startswith("_") or key not in (kinds := self._kinds()):
            raise UnknownKey(self._unknown(key))
        inner = without_annotations(kinds[key])
        if get_origin(inner) is dict or members(inner) or _is_model(inner):
            return Keys(inner, f"{self._where}.{key}", key, self, self._folder)
        fields = self._model.model_fields.values() if self._model else ()
        field = next((f for f in fields if f.alias == key), None)
        field = field or (self._model.model_fields.get(key) if self._model else None)
        if field is None or field.default is PydanticUndefined:
            raise UnknownKey(f"{self._where}.{key}: not given; it has no default")
        return deepcopy(field.default)

    def __setattr__(self, key: str, value: Any) -> None:
        named = get_origin(without_annotations(self._kind)) is dict
        if not named and key not in self._kinds():
            raise UnknownKey(self._unknown(key))
        check(self._kind, self._model, {**self._table, key: value}, key, self._where, self._folder)
        self[key] = value

    def __delattr__(self, key: str) -> None:
        del self[key]

    def __dir__(self) -> list[str]:
        return sorted(self._kinds())

    def __deepcopy__(self, memo: Any) -> Tables:
        return deepcopy(self._table, memo)

    def __eq__(self, other: object) -> bool:
        return self._table == (other._table if isinstance(other, Keys) else other)

    def __repr__(self) -> str:
        return repr(self._table)

    def _unknown(self, key: str) -> str:
        return f"{self._where}.{key}: unknown key{nearest(key, self._kinds())}"


class Items(MutableSequence[Any]):
    """A list of tables of a case; each is a `Keys`."""

    def __init__(self, kind: Any, where: str, items: list[Any], folder: Path) -> None:
        self._kind, self._where, self._items, self._folder = kind, where, items, folder

    def __getitem__(self, index: Any) -> Any:
        item = self._items[index]
        if not isinstance(item, dict):
            return item
        return Keys(self._kind, f"{self._where}.{index}", "", {"": item}, self._folder)

    def __setitem__(self, index: Any, value: Any) -> None:
        self._items[index] = raw(value)

    def __delitem__(self, index: Any) -> None:
        del self._items[index]

    def __len__(self) -> int:
        return len(self._items)

    def insert(self, index: int, value: Any) -> None:
        """Insert a table."""
        self._items.insert(index, raw(value))

    def __deepcopy__(self, memo: Any) -> list[Any]:
        return deepcopy(self._items, memo)

    def __repr__(self) -> str:
        return repr(self._items)


def raw(value: Any) -> Any:
    """Return a value as the case keeps it: tables and lists without a view."""
    if isinstance(value, Keys):
        return value._table
    return value._items if isinstance(value, Items) else value


def check(
    kind: Any,
    model: type[BaseModel] | None,
    table: Mapping[str, Any],
    key: str,
    where: str,
    folder: Path,
) -> None:
    """Raise InputError if a key of a table has a wrong value; what is missing is no error yet.

    Parameters
    ----------
    kind : type of the table, or of its values
    model : pydantic model of the table, if it has one
    table : keys and values so far
    key : the key that is set
    where : path of the table in the case, for messages
    folder : folder for relative names of files
    """
    given, context = plain(table), {FOLDER: folder}
    try:
        if model is not None:
            model.model_validate(given, context=context)
        else:
            TypeAdapter(kind).validate_python({key: given[key]}, context=context)
    except ValidationError as error:
        own = re.compile(rf"{re.escape(key)}(?=[ .:])(?!.*: missing; )")
        lines = [line for line in bare_lines(error, model or kind) if own.match(line)]
        if lines:
            prefix = f"{where}." if where else ""
            raise InputError("\n".join(f"{prefix}{line}" for line in lines)) from None


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)
