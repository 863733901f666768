"""How Python calls compiled code: types as text, tables of structures, arguments as words.

Texts say what a call is looked up and kept by, without Numba. They are literals of Python:

'f8' 'i8' 'b1' 'c16'                    a number; 'n': nothing
('array', 'f8', 2, 'C', True)           its numbers, axes, layout, and whether it may be written
('tuple', 'module:Class', (...))        a NamedTuple of such parts; without a name: a tuple
('structure', 'Class', names, (...))    a structure, by pointer

A structure is a NamedTuple that compiled code sees as one pointer. The pointer leads to a table of
8-byte words: address and lengths of each array, the value of each number, the words of a structure
inside. Compiled code loads what it needs and is spared the hundreds of words that the arrays of a
model and its memory take. Python sees the tuple.
"""

import ast
import ctypes
import struct
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple, TypeVar

import numpy as np


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


_KINDS = {"array": ArrayOf, "tuple": TupleOf, "structure": StructureOf}


def parse(text: str) -> Any:
    """Return what a text says."""
    return _said(ast.literal_eval(text))


def parse_all(text: str) -> tuple[Any, ...]:
    """Return the arguments of a call: the parts of a tuple."""
    return tuple(parse(text).parts)


def _said(value: Any) -> Any:
    if isinstance(value, str):
        return Number(value)
    kind, *fields = value
    if kind != "array":
        fields[-1] = tuple(map(_said, fields[-1]))
    return _KINDS[kind](*fields)


def text_of_tuple(parts: Iterable[str], name: str = "") -> str:
    """Return the text of a tuple of the texts of its parts."""
    return f"('tuple',{name!r},({''.join(f'{part},' for part in parts)}))"


def text_of_array(code: str, ndim: int, layout: str = "C", *, mutable: bool = True) -> str:
    """Return the text of an array.

    Parameters
    ----------
    code : type of the numbers, as 'f8'
    ndim : number of axes
    layout : 'C', or 'A' with strides
    mutable : whether the array may be written
    """
    return repr(("array", code, ndim, layout, mutable))


def text_of_structure(name: str, fields: Mapping[str, str]) -> str:
    """Return the text of a structure of the texts of its fields."""
    return f"('structure',{name!r},{(*fields,)!r},({''.join(f'{f},' for f in fields.values())}))"


def leaves(kind: Any) -> list[str]:
    """Return the codes of all numbers in a result, in order."""
    if isinstance(kind, TupleOf):
        return [code for part in kind.parts for code in leaves(part)]
    return [] if kind.code == "n" else [kind.code]


def class_named(name: str) -> Any:
    """Return the class of a text module:Class."""
    module, _, qualified = name.partition(":")
    item: Any = import_module(module)
    for part in qualified.split("."):
        item = getattr(item, part)
    return item


Class = TypeVar("Class", bound=type)

_NUMBERS: dict[Any, str] = {int: "i8", float: "f8", bool: "b1", complex: "c16"}
_PLAIN, _ALIGNED, _WRITABLE = 0x101, 0x100, 0x400  # flags of arrays: contiguous and aligned, ...
_DATA = 16  # bytes from the beginning of an array object to the address of its data
_PACKED = {"i8": np.int64, "b1": np.int64, "f8": np.float64}


class Table(NamedTuple):
    """The words of one structure, and the text that says what they are."""

    text: str
    words: Any  # (n,) int64
    address: int


def structure(cls: Class) -> Class:
    """Mark a NamedTuple of contiguous arrays, numbers and structures: compiled, one pointer.

    Its arrays may be filled, and never change their place or length.
    """

    class Structure(cls):  # type: ignore[valid-type, misc]
        is_structure = True

        def __getstate__(self) -> None:
            """Leave the table behind: addresses mean nothing to a copy."""

    for name in ("__name__", "__qualname__", "__module__", "__doc__"):
        setattr(Structure, name, getattr(cls, name))
    Structure.__annotations__ = dict(cls.__annotations__)
    return Structure  # type: ignore[return-value]


def table_of(value: Any) -> Table:
    """Return the table of a structure, which lives as long as the tuple.

    Raises TypeError : a field that compiled code cannot be given
    """
    table = value.__dict__.get("_table")
    if table is None:
        words: list[int] = []
        text = _describe(value, words)
        array = np.array(words, dtype=np.uint64).view(np.int64)
        table = value.__dict__["_table"] = Table(text, array, array.ctypes.data)
    return table  # type: ignore[no-any-return]


@cache
def _text_of(dtype: np.dtype[Any], ndim: int) -> str:
    """Return what an array is; nothing if its numbers are not in the order of this machine."""
    return text_of_array(dtype.str[1:], ndim) if dtype.isnative else ""


def _describe(value: Any, words: list[int]) -> str:
    """Append the words of a structure; return its text."""
    cls = type(value)
    fields: dict[str, str] = {}
    for name, field in zip(cls._fields, value, strict=True):
        if isinstance(field, np.ndarray):
            text = _text_of(field.dtype, field.ndim)
            if field.flags.num & _PLAIN != _PLAIN or not text:
                raise TypeError(f"{cls.__name__}.{name}: expected a contiguous array")
            words.append(address_of(field))
            words.extend(field.shape)
        elif hasattr(field, "is_structure"):  # models that differ in numbers share most of theirs
            table = table_of(field)
            text = table.text
            words.extend(table.words.view(np.uint64).tolist())
        else:
            code = _NUMBERS.get(cls.__annotations__[name], "")
            if code not in _PACKED:
                raise TypeError(f"{cls.__name__}.{name}: expected an array, a number, a structure")
            words.append(int(np.array(field, dtype=_PACKED[code]).view(np.uint64)))
            text = repr(code)
        fields[name] = text
    return text_of_structure(cls.__name__, fields)


@cache
def array_head_is_known() -> bool:
    """Return whether array objects begin as compiled code expects (ndarrayobject.h of NumPy)."""
    array = np.zeros((2, 3))[:, ::2]
    if tuple.__itemsize__ != 8 or not hasattr(ctypes, "PYFUNCTYPE"):
        return False
    head = (ctypes.c_int64 * 6).from_address(id(array))
    if head[2] != array.ctypes.data or ctypes.c_int32.from_address(id(array) + 24).value != 2:
        return False
    lengths = (ctypes.c_int64 * 2).from_address(head[4])
    strides = (ctypes.c_int64 * 2).from_address(head[5])
    return tuple(lengths) == array.shape and tuple(strides) == array.strides


def address_of(array: np.ndarray[Any, Any]) -> int:
    """Return the address of the data; the way of NumPy takes four times as long."""
    if array_head_is_known():
        return ctypes.c_uint64.from_address(id(array) + _DATA).value
    return array.__array_interface__["data"][0]  # type: ignore[no-any-return]


_LETTERS = {"f8": "d", "i8": "q", "b1": "q", "c16": "dd"}


def described(arguments: tuple[Any, ...]) -> tuple[Any, list[Any]]:
    """Return a key of the types of arguments, and their words; None if there is no word."""
    kinds: list[Any] = []
    words: list[Any] = []
    for value in arguments:
        cls = type(value)
        if cls is np.ndarray:
            kinds.append((value.dtype, value.ndim, value.flags.num))
            words.append(id(value))
        elif cls is float or cls is int or cls is bool:
            kinds.append(cls)
            words.append(value)
        elif hasattr(cls, "is_structure"):
            table = table_of(value)
            kinds.append(table.text)
            words.append(table.address)
        elif isinstance(value, float | np.floating):
            kinds.append(float)
            words.append(float(value))
        elif isinstance(value, np.bool_):
            kinds.append(bool)
            words.append(bool(value))
        elif isinstance(value, np.integer):
            kinds.append(int)
            words.append(int(value))
        elif isinstance(value, complex | np.complexfloating):
            kinds.append(complex)
            words += [value.real, value.imag]
        else:
            return None, words
    return tuple(kinds), words


def text(kinds: tuple[Any, ...]) -> str | None:
    """Return the types of arguments as text, from the key that `described` returns.

    None if compiled code cannot be given them.
    """
    texts = []
    for kind in kinds:
        if isinstance(kind, tuple):
            dtype, ndim, flags = kind
            if not (flags & _ALIGNED and dtype.isnative and dtype.kind in "fcib"):
                return None
            layout, mutable = "C" if flags & 1 else "A", bool(flags & _WRITABLE)
            texts.append(text_of_array(dtype.str[1:], ndim, layout, mutable=mutable))
        else:
            texts.append(kind if isinstance(kind, str) else repr(_NUMBERS[kind]))
    return text_of_tuple(texts)


def door(address: int, kinds: tuple[Any, ...], result: Any) -> Callable[..., Any]:
    """Return what calls the code at an address with words, and makes a result of its words.

    `kinds` are those of `described`: reading the long texts of structures would take 2 ms each.

    Parameters
    ----------
    address : address of the entry point
    kinds : types of the arguments
    result : type of the result
    """
    call = ctypes.PYFUNCTYPE(None, ctypes.c_char_p, ctypes.c_void_p)(address)
    form = [_LETTERS[_NUMBERS[k]] if isinstance(k, type) else "q" for k in kinds]
    packed = struct.Struct("=" + "".join(form)).pack
    codes = leaves(result)
    if not codes:

        def run(words: list[Any], arguments: Any) -> None:
            call(packed(*words), None)

        return run
    back = struct.Struct("=" + "".join(_LETTERS[code] for code in codes))
    made = _maker(result)

    def run_back(words: list[Any], arguments: Any) -> Any:
        space = ctypes.create_string_buffer(back.size)
        call(packed(*words), space)
        return made(iter(back.unpack(space)))

    return run_back


def _maker(kind: Any) -> Callable[[Any], Any]:
    """Return what takes numbers from an iterator and makes a result of them."""
    if isinstance(kind, TupleOf):
        parts = [_maker(part) for part in kind.parts]
        if not kind.name:
            return lambda numbers: tuple(part(numbers) for part in parts)
        cls = class_named(kind.name)
        return lambda numbers: cls(*(part(numbers) for part in parts))
    if kind.code == "b1":
        return lambda numbers: bool(next(numbers))
    if kind.code == "c16":
        return lambda numbers: complex(next(numbers), next(numbers))
    return next
