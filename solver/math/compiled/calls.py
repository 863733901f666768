"""Numba's types of arguments, how calls hand them over, and the code of a call.

A structure is one pointer. A unit takes an array of layout C as its address and lengths; others
with their strides as well.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import lower_constant
from numba.core.typing.templates import AttributeTemplate, infer_getattr, signature
from numba.extending import lower_getattr_generic, register_model, typeof_impl
from numba.np import arrayobj
from numba.np.numpy_support import as_dtype, from_dtype

from . import signatures
from .lowering import define, lower
from .parts import Part

_WORD = ir.IntType(64)
_POINTER = ir.IntType(8).as_pointer()


class StructureType(types.Type):
    """A pointer to a table of words (structures.py)."""

    def __init__(self, kind: signatures.StructureOf) -> None:
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
    if isinstance(kind, signatures.StructureOf):
        return StructureType(kind)
    if isinstance(kind, signatures.ArrayOf):
        number = from_dtype(np.dtype(kind.code))
        return types.Array(number, kind.ndim, kind.layout, readonly=not kind.mutable)
    if isinstance(kind, signatures.TupleOf):
        parts = [numba_type(part) for part in kind.parts]
        return types.BaseTuple.from_types(
            parts, signatures.class_named(kind.name) if kind.name else None
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


_results: dict[Any, Any] = {}


class PartType(types.Callable, types.Dummy):  # type: ignore[misc]
    """A function that is compiled by itself, or becomes code of its callers (parts.py)."""

    def __init__(self, part: Any) -> None:
        self.part = part
        super().__init__(f"part({part.name})")

    @property
    def key(self) -> Any:
        """What tells this type from others."""
        return self.part

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call; compile or load what is called."""
        part = self.part.of_count(len(args))
        if kws or part is None:
            raise TypeError(f"{self.part.name}: other arguments expected, by position")
        kinds = tuple(types.unliteral(kind) for kind in args)
        if not all(kind.is_precise() for kind in kinds):
            return None
        return signature(result_of_call(part, kinds), *kinds)

    def get_call_signatures(self) -> Any:
        """Return what Numba lists in an error."""
        return (), False

    def get_impl_key(self, sig: Any) -> Any:
        """Return what the code of a call is found by."""
        return self.part.of_count(len(sig.args)), sig.args


@register_model(PartType)
class _PartModel(models.OpaqueModel):  # type: ignore[misc]
    pass


@lower_constant(PartType)  # type: ignore[misc]
def _no_value(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return context.get_dummy_value()


typeof_impl.register(Part)(lambda value, context: PartType(value))


def result_of_call(part: Part, kinds: tuple[Any, ...]) -> Any:
    """Return the type of a part's result; its code is there afterwards."""
    key = part, kinds
    if key in _results:
        return _results[key]
    if part.inline:
        lowered = lower(part, kinds)
        result = lowered.result

        def code(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            context.active_code_library.add_linking_library(lowered.modules)
            return context.call_internal(builder, lowered.description, sig, arguments)

    else:
        unit = part.unit(_text(kinds))
        result = numba_type(signatures.parse(unit.result))

        def code(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            context.active_code_library.needed[unit.symbol] = unit
            return _call_unit(context, builder, sig, arguments, unit.symbol)

    define(code, key, kinds)
    _results[key] = result
    return result


def _text(kinds: tuple[Any, ...]) -> str:
    return "(" + ",".join(text_of(kind) for kind in kinds) + ")"


def unit_type(context: Any, kinds: tuple[Any, ...], result: Any) -> Any:
    """Return the type of a unit, as LLVM sees it."""
    flat = [t for kind in kinds for t in flat_types(context, kind)]
    back = ir.VoidType() if result is types.none else context.get_value_type(result)
    return ir.FunctionType(back, flat)


def _declared(module: Any, function_type: Any, symbol: str) -> Any:
    if symbol in module.globals:
        return module.globals[symbol]
    return ir.Function(module, function_type, symbol)


def _call_unit(context: Any, builder: Any, sig: Any, arguments: Any, symbol: str) -> Any:
    function = _declared(builder.module, unit_type(context, sig.args, sig.return_type), symbol)
    flat = [
        value
        for kind, argument in zip(sig.args, arguments, strict=True)
        for value in flattened(context, builder, kind, argument)
    ]
    result = builder.call(function, flat)
    return context.get_dummy_value() if sig.return_type is types.none else result


def flat_types(context: Any, kind: Any) -> list[Any]:
    """Return the types by which one argument is handed over: an array as address and lengths."""
    if isinstance(kind, types.Array):
        n = kind.ndim if kind.layout == "C" else 2 * kind.ndim
        return [context.get_data_type(kind.dtype).as_pointer()] + [_WORD] * n
    if isinstance(kind, types.BaseTuple):
        return [t for part in kind.types for t in flat_types(context, part)]
    return [context.get_value_type(kind)]


def flattened(context: Any, builder: Any, kind: Any, value: Any) -> list[Any]:
    """Return the values by which one argument is handed over."""
    if isinstance(kind, types.Array):
        array = arrayobj.make_array(kind)(context, builder, value)
        lengths = cgutils.unpack_tuple(builder, array.shape, kind.ndim)
        if kind.layout != "C":
            lengths = [*lengths, *cgutils.unpack_tuple(builder, array.strides, kind.ndim)]
        return [array.data, *lengths]
    if isinstance(kind, types.BaseTuple):
        parts = enumerate(kind.types)
        return [
            v
            for i, part in parts
            for v in flattened(context, builder, part, builder.extract_value(value, i))
        ]
    return [value]


def whole(context: Any, builder: Any, kind: Any, values: Any) -> Any:
    """Return the argument that the next of `values` (an iterator) hand over."""
    if isinstance(kind, types.Array):
        data = next(values)
        shape = [next(values) for _ in range(kind.ndim)]
        strides = None if kind.layout == "C" else [next(values) for _ in range(kind.ndim)]
        return whole_array(context, builder, kind, data, shape, strides)
    if isinstance(kind, types.BaseTuple):
        parts = [whole(context, builder, part, values) for part in kind.types]
        return context.make_tuple(builder, kind, parts)
    return next(values)
