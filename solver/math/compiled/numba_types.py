"""Numba data model of structures: their types, and code for access to their fields."""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import lower_getattr_generic, register_model
from numba.np import arrayobj
from numba.np.numpy_support import as_dtype, from_dtype

from . import signatures as texts

_WORD = ir.IntType(64)
_POINTER = ir.IntType(8).as_pointer()


class StructureType(types.Type):
    """A pointer to a table of words (structures.py)."""

    def __init__(self, kind: texts.StructureOf) -> None:
        self.class_name = kind.name
        self.fields = {
            name: numba_type(part) for name, part in zip(kind.names, kind.parts, strict=True)
        }
        self.offsets, self.n_word = {}, 0
        for name, field in self.fields.items():
            self.offsets[name] = self.n_word
            self.n_word += _words_of(field)
        parts = ",".join(f"{name}={text_of(field)}" for name, field in self.fields.items())
        super().__init__("{" + f"{kind.name}:{parts}" + "}")


def _words_of(field: Any) -> int:
    if isinstance(field, StructureType):
        return field.n_word
    return 1 + field.ndim if isinstance(field, types.Array) else 1


_BY_TEXT: dict[Any, Any] = {}


def numba_type(kind: Any) -> Any:
    """Return Numba's type of what a text says (signatures.py)."""
    if kind not in _BY_TEXT:
        _BY_TEXT[kind] = _numba_type(kind)
    return _BY_TEXT[kind]


def _numba_type(kind: Any) -> Any:
    if isinstance(kind, texts.StructureOf):
        return StructureType(kind)
    if isinstance(kind, texts.ArrayOf):
        number = from_dtype(np.dtype(kind.code))
        return types.Array(number, kind.ndim, kind.layout, readonly=not kind.mutable)
    if isinstance(kind, texts.TupleOf):
        parts = [numba_type(part) for part in kind.parts]
        return types.BaseTuple.from_types(
            parts, texts.class_named(kind.name) if kind.name else None
        )
    if kind.code == "n":
        return types.none
    return types.boolean if kind.code == "b1" else from_dtype(np.dtype(kind.code))


def text_of(kind: Any) -> str:
    """Return the text of one of Numba's types.

    Raises TypeError : a type that has none
    """
    kind = types.unliteral(kind)
    if isinstance(kind, StructureType):
        return str(kind.name)
    if isinstance(kind, types.Array):
        layout = "" if kind.layout == "C" else kind.layout
        return f"{_code(kind.dtype)}[{kind.ndim}]{layout}{'' if kind.mutable else '!'}"
    if isinstance(kind, types.BaseTuple):
        parts = ",".join(text_of(part) for part in kind.types)
        cls = getattr(kind, "instance_class", tuple)
        name = "" if cls is tuple else f"<{cls.__module__}:{cls.__qualname__}>"
        return f"{name}({parts})"
    return "n" if kind is types.none else _code(kind)


def _code(kind: Any) -> str:
    if not isinstance(kind, types.Number | types.Boolean):
        raise TypeError(f"{kind}: neither a number, an array, a tuple nor a structure")
    return str(as_dtype(kind).str[1:])


@register_model(StructureType)
class _StructureModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _POINTER)


@infer_getattr
class _StructureFields(AttributeTemplate):  # type: ignore[misc]
    key = StructureType

    def generic_resolve(self, kind: StructureType, name: str) -> Any:
        return kind.fields.get(name)


@lower_getattr_generic(StructureType)  # type: ignore[misc]
def _load_field(context: Any, builder: Any, kind: StructureType, value: Any, name: str) -> Any:
    field, offset = kind.fields[name], kind.offsets[name]
    table = builder.bitcast(value, _WORD.as_pointer())

    def load(k: int, as_type: Any = _WORD) -> Any:
        place = builder.gep(table, [ir.Constant(ir.IntType(32), offset + k)])
        return fixed_load(builder, builder.bitcast(place, as_type.as_pointer()))

    if isinstance(field, StructureType):
        place = builder.gep(table, [ir.Constant(ir.IntType(32), offset)])
        return builder.bitcast(place, _POINTER)
    if isinstance(field, types.Array):
        data = context.get_data_type(field.dtype).as_pointer()
        return whole_array(
            context, builder, field, load(0, data), [load(1 + a) for a in range(field.ndim)]
        )
    if isinstance(field, types.Boolean):
        return builder.icmp_signed("!=", load(0), ir.Constant(_WORD, 0))
    return load(0, context.get_value_type(field))


def fixed_load(builder: Any, pointer: Any) -> Any:
    """Return the value at a pointer, which nothing changes as long as compiled code runs."""
    value = builder.load(pointer)
    value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value


def whole_array(
    context: Any, builder: Any, kind: Any, data: Any, shape: list[Any], strides: Any = None
) -> Any:
    """Return an array of data and lengths; strides are those of layout C if not given."""
    made = arrayobj.make_array(kind)(context, builder)
    size = ir.Constant(_WORD, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    if strides is None:
        strides, step = [], size
        for length in reversed(shape):
            strides.insert(0, step)
            step = builder.mul(step, length)
    arrayobj.populate_array(
        made, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None, parent=None
    )
    return made._getvalue()
