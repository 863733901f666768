"""Types of arguments and results as text: what a call is looked up and kept by, without Numba.

f8 i8 b1 c16 ...        a number
f8[2] f8[1]A f8[1]!     an array of so many axes; strided; read-only
(f8,f8,f8)              a tuple
<module:Class>(f8,...)  a NamedTuple
{Class:name=f8[1],...}  a structure, by pointer
n                       nothing
"""

import re
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

_WORD = re.compile(r"[a-z]\d*")
_ARRAY = re.compile(r"\[(\d+)\]([AF]?)(!?)")


class Number(NamedTuple):
    """A number by NumPy's short name of its type; "n" is no number at all."""

    code: str


class ArrayOf(NamedTuple):
    """An array: numbers, axes, layout "C", "F" or "A", and whether it may be written."""

    code: str
    ndim: int
    layout: str
    mutable: bool


class TupleOf(NamedTuple):
    """A tuple, or a NamedTuple of the class `name` (module:Class)."""

    name: str
    parts: tuple[Any, ...]


class StructureOf(NamedTuple):
    """A structure: its class, the names of its fields and what they are."""

    name: str
    names: tuple[str, ...]
    parts: tuple[Any, ...]


def parse(text: str) -> Any:
    """Return what a text says."""
    found, end = _any(text, 0)
    if end != len(text):
        raise ValueError(f"signature {text!r}: not understood at {end}")
    return found


def parse_all(text: str) -> tuple[Any, ...]:
    """Return the arguments of a call: texts between brackets."""
    return tuple(parse(text).parts)


def _any(text: str, at: int) -> tuple[Any, int]:
    if text[at] == "{":
        end = text.index(":", at)
        name, names = text[at + 1 : end], []

        def field(start: int) -> tuple[Any, int]:
            equal = text.index("=", start)
            names.append(text[start:equal])
            return _any(text, equal + 1)

        parts, after = _list(text, end + 1, "}", field)
        return StructureOf(name, tuple(names), parts), after
    name = ""
    if text[at] == "<":
        end = text.index(">", at)
        name, at = text[at + 1 : end], end + 1
    if text[at] == "(":
        parts, after = _list(text, at + 1, ")", lambda start: _any(text, start))
        return TupleOf(name, parts), after
    word = _WORD.match(text, at)
    if word is None:
        raise ValueError(f"signature {text!r}: not understood at {at}")
    array = _ARRAY.match(text, word.end())
    if array is None:
        return Number(word[0]), word.end()
    return ArrayOf(word[0], int(array[1]), array[2] or "C", not array[3]), array.end()


def _list(
    text: str, at: int, end: str, one: Callable[[int], tuple[Any, int]]
) -> tuple[tuple[Any, ...], int]:
    parts = []
    while text[at] != end:
        part, at = one(at)
        parts.append(part)
        if text[at] == ",":
            at += 1
    return tuple(parts), at + 1


def leaves(kind: Any) -> list[str]:
    """Return the codes of all numbers in a result, in order."""
    if isinstance(kind, TupleOf):
        return [code for part in kind.parts for code in leaves(part)]
    return [] if kind.code == "n" else [kind.code]


def class_named(name: str) -> Any:
    """Return the class of a text module:Class."""
    module, _, qualified = name.partition(":")
    found: Any = import_module(module)
    for part in qualified.split("."):
        found = getattr(found, part)
    return found
