"""Check of plain data (JSON) against the TypedDict of their form.

Keys, types and literals are checked; the writer of the file has checked the values.
"""

import math
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints, is_typeddict

from ...errors import did_you_mean

SCALARS = {str: "a text", bool: "true or false", int: "a whole number", float: "a number"}


class SpecError(ValueError):
    """A specification that cannot be used; names key, value and expectation."""


def expected(key: str, value: Any, expectation: str) -> str:
    """Message for a wrong value."""
    return f"{key or 'specification'}: expected {expectation}, found {value!r}"


def check_form(value: Any, form: Any, key: str = "") -> None:
    """Raise SpecError for the first entry of `value` with a wrong form.

    Parameters
    ----------
    form : a TypedDict, Literal, list[...], dict[str, ...], a union of such, str, bool, int, float
        or Any. In a union of tables the key `kind` selects one.
    key : of the value, for messages
    """
    origin = get_origin(form)
    if origin in (Union, UnionType):
        form = _meant(value, get_args(form), key)
        origin = get_origin(form)
    if form is Any:
        return
    if is_typeddict(form):
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
    else:
        _require(_is(value, form), key, value, _words(form))


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
    if kind not in kinds:
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
    return SCALARS.get(form, "a list" if get_origin(form) is list else "an object")


def _require(fulfilled: bool, key: str, value: Any, expectation: str) -> None:
    if not fulfilled:
        raise SpecError(expected(key, value, expectation))


def _join(where: str, key: Any) -> str:
    return f"{where}.{key}" if where else str(key)
