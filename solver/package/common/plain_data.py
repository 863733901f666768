"""Plain data (JSON): text and hash of the content, shares of a list, TOML text, and its form.

`check_form` compares a table with a TypedDict: keys, types and literals. The writer of the file has
checked the values.
"""

import argparse
import hashlib
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints, is_typeddict

import numpy as np

from ...errors import PackageError, did_you_mean

# The path of a mesh does not affect results: next to these keys, `sha256` is the hash of its
# content.
PLACES = ("file", "arrays")
DIGITS = 12  # the last ones of a cosine in the spacing of a mesh depend on the machine


def plain(value: Any, *, finite: bool = False) -> Any:
    """Return a value as plain data: tuples and arrays as lists, NumPy's numbers as Python's.

    Parameters
    ----------
    value : of tables, lists, arrays, numbers, texts and paths
    finite : NaN and infinity become None, as JSON has neither
    """
    if isinstance(value, Mapping):
        return {str(key): plain(item, finite=finite) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, finite=finite) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist(), finite=finite)
    if finite and isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def canonical(data: Any) -> str:
    """Return the JSON text that is the same for the same content."""
    return json.dumps(data, sort_keys=True)


def cell_text(text: str) -> str:
    """Return a text as a cell of a CSV table that no spreadsheet takes for a formula."""
    return f"'{text}" if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text


def csv_text(rows: Iterable[Iterable[Any]], end: str = "\r\n") -> str:
    """Return rows of texts and numbers as a CSV table, whose lines end with `end`."""
    import csv  # runs write none

    stream = io.StringIO(newline="")
    csv.writer(stream, lineterminator=end).writerows(rows)
    return stream.getvalue()


def data_sha256(data: Any) -> str:
    """Return the hash of plain data with all digits."""
    return hashlib.sha256(canonical(data).encode()).hexdigest()


def inputs_sha256(data: Any) -> str:
    """Return the hash of a specification: meshes by their content, numbers to `DIGITS` digits."""
    return data_sha256(_inputs(data))


def _inputs(data: Any) -> Any:
    if isinstance(data, dict):
        left_out = PLACES if "sha256" in data else ()
        return {key: _inputs(value) for key, value in data.items() if key not in left_out}
    if isinstance(data, list | tuple):
        return [_inputs(value) for value in data]
    return float(f"{data:.{DIGITS}g}") if isinstance(data, float) else data


def toml_text(table: dict[str, object], path: str = "") -> str:
    """Return plain values, lists and tables as TOML text."""
    lines = [f"{_key(k)} = {toml_value(v)}" for k, v in table.items() if not isinstance(v, dict)]
    for key, value in table.items():
        if isinstance(value, dict):
            name = f"{path}{_key(key)}"
            lines += [f"\n[{name}]", toml_text(value, f"{name}.").rstrip("\n")]
    return "\n".join(lines).lstrip("\n") + "\n"


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else toml_value(key)


def toml_value(value: Any) -> str:
    """Return a value on one line; a table within a list becomes an inline table."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {toml_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    # JSON with its own letters: TOML has no pairs of surrogates, and takes no bare DEL.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


Form = TypeVar("Form")
SCALARS = {str: "a text", bool: "true or false", int: "a whole number", float: "a number"}


class SpecError(ValueError):
    """A specification that cannot be used; names key, value and expectation."""


def expected(key: str, value: Any, expectation: str) -> str:
    """Message for a wrong value.

    Parameters
    ----------
    key : key of the value
    value : the wrong value
    expectation : what was expected
    """
    return f"{key or 'specification'}: expected {expectation}, found {value!r}"


def check_form(value: Any, form: type[Form], key: str = "") -> Form:
    """Return a value of this form. Raises SpecError for the first entry of another form.

    Parameters
    ----------
    form : a TypedDict, Literal, list[...], dict[str, ...], a union of such, str, bool, int, float
        or object. In a union of tables the key `kind` selects one.
    key : of the value, for messages
    """
    origin = get_origin(form)
    if origin in (Union, UnionType):
        check_form(value, _meant(value, get_args(form), key), key)
    elif is_typeddict(form):
        _check_table(value, form, key)
    elif origin is Literal:
        if value not in get_args(form):
            hint = did_you_mean(str(value), map(str, get_args(form)))
            raise SpecError(expected(key, value, _words(form)) + hint)
    elif origin is list:
        _require(isinstance(value, list), key, value, "a list")
        for i, entry in enumerate(value):
            check_form(entry, get_args(form)[0], f"{key}[{i}]")
    elif origin is dict:
        _require(isinstance(value, dict), key, value, "an object")
        for name, entry in value.items():
            check_form(entry, get_args(form)[1], _join(key, name))
    elif form is not object:
        _require(_is(value, form), key, value, _words(form))
    checked: Form = value
    return checked


def _check_table(table: Any, form: Any, where: str) -> None:
    known = get_type_hints(form)
    _require(isinstance(table, dict), where, table, f"an object with {', '.join(known)}")
    for key in table:
        if key not in known:
            hint = did_you_mean(str(key), known)
            name = _join(where, key)
            raise SpecError(f"{name}: unknown key{hint} (known: {', '.join(known)})")
    for key in known:
        if key in table:
            check_form(table[key], known[key], _join(where, key))
        elif key in form.__required_keys__:
            raise SpecError(f"{_join(where, key)}: missing; expected {_words(known[key])}")


def _meant(value: Any, forms: tuple[Any, ...], key: str) -> Any:
    """The member of a union that a value belongs to."""
    if not all(map(is_typeddict, forms)):
        fitting = [form for form in forms if _fits(value, form)]
        _require(bool(fitting), key, value, " or ".join(map(_words, forms)))
        return fitting[0]
    kind = value.get("kind") if isinstance(value, dict) else None
    kinds = {word: form for form in forms for word in get_args(get_type_hints(form)["kind"])}
    _require(isinstance(value, dict), key, value, "an object")
    if not isinstance(kind, str) or kind not in kinds:
        expectation = f"one of {', '.join(kinds)}"
        raise SpecError(expected(f"{key}.kind", kind, expectation) + did_you_mean(str(kind), kinds))
    return kinds[kind]


def _fits(value: Any, form: Any) -> bool:
    try:
        check_form(value, form)
    except SpecError:
        return False
    return True


def _is(value: Any, form: type) -> bool:
    if form is float:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        return number and math.isfinite(value)
    return isinstance(value, form) and (form is bool or not isinstance(value, bool))


def _words(form: Any) -> str:
    if get_origin(form) is Literal:
        return f"one of {', '.join(map(str, get_args(form)))}"
    if get_origin(form) in (Union, UnionType):
        return " or ".join(map(_words, get_args(form)))
    if is_typeddict(form):
        asked = (key for key in get_type_hints(form) if key in form.__required_keys__)
        return f"an object with {', '.join(asked)}"
    return SCALARS.get(form, "a list" if get_origin(form) is list else "an object")


def _require(fulfilled: bool, key: str, value: Any, expectation: str) -> None:
    if not fulfilled:
        raise SpecError(expected(key, value, expectation))


def _join(where: str, key: Any) -> str:
    return f"{where}.{key}" if where else str(key)


Item = TypeVar("Item")


def mesh_key(spec: Mapping[str, Any]) -> str:
    """Text that is equal for specifications of equal meshes."""
    return canonical(spec.get("mesh"))


def by_mesh(items: Iterable[tuple[Item, str]]) -> list[list[Item]]:
    """Groups of items of equal mesh, from (item, `mesh_key`); all in order of appearance."""
    groups: dict[str, list[Item]] = {}
    for item, key in items:
        groups.setdefault(key, []).append(item)
    return list(groups.values())


def share(items: Sequence[Item], part: tuple[int, int]) -> list[Item]:
    """The k-th of N contiguous shares, part = (k, N) with k from 1; together they are complete."""
    k, n = part
    return list(items[len(items) * (k - 1) // n : len(items) * k // n])


def shard(text: str) -> tuple[int, int]:
    """(k, N) of the option --shard k/N."""
    k, slash, n = text.partition("/")
    if slash and k.isdecimal() and n.isdecimal() and 1 <= int(k) <= int(n):
        return int(k), int(n)
    raise argparse.ArgumentTypeError(f"{text!r}: expected k/N with k from 1 to N, such as 2/8")


def json_text(where: str, value: Any) -> str:
    """Return JSON text; arrays become lists. Raises PackageError for values that are not JSON."""
    try:
        return json.dumps(plain(value))
    except (TypeError, ValueError) as cause:
        raise PackageError(f"{where}: {cause}") from cause


def json_table(where: str, text: str) -> dict[str, object]:
    """Return the table of a JSON text. Raises PackageError."""
    try:
        table = json.loads(text)
    except json.JSONDecodeError as cause:
        raise PackageError(f"{where}: not JSON: {cause}") from cause
    return table if isinstance(table, dict) else {where.rsplit(" ", 1)[-1]: table}
