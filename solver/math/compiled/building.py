"""Object code of units and of their entry points from Python: types, calls, whole modules.

A structure is one pointer. A unit takes an array of layout C as its address and lengths; others
with their strides as well.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.datamodel import models
from numba.core.imputils import lower_constant
from numba.core.typing.templates import AttributeTemplate, infer_getattr, signature
from numba.extending import lower_getattr_generic, register_model, typeof_impl
from numba.np import arrayobj
from numba.np.numpy_support import as_dtype, from_dtype

from . import machine
from .entry_points import (
    ArrayOf,
    StructureOf,
    TupleOf,
    class_named,
    parse,
    parse_all,
    text_of_array,
    text_of_structure,
    text_of_tuple,
)
from .lowering import CONTEXT, define, fast_compilation, lower
from .parts import Part, digest

_WORD = ir.IntType(64)
_POINTER = ir.IntType(8).as_pointer()


class StructureType(types.Type):
    """A pointer to a table of words (entry_points.py)."""

    def __init__(self, kind: StructureOf) -> None:
        self.fields = {
            name: numba_type(part) for name, part in zip(kind.names, kind.parts, strict=True)
        }
        self.offsets, self.n_word = {}, 0
        for name, field in self.fields.items():
            self.offsets[name] = self.n_word
            self.n_word += _words_of(field)
        texts = {name: text_of(field) for name, field in self.fields.items()}
        self.text = text_of_structure(kind.name, texts)
        super().__init__(f"{kind.name}.{digest(self.text)}")


def _words_of(field: Any) -> int:
    if isinstance(field, StructureType):
        return field.n_word
    return 1 + field.ndim if isinstance(field, types.Array) else 1


_BY_TEXT: dict[Any, Any] = {}


def numba_type(kind: Any) -> Any:
    """Return Numba's type of what a text says (entry_points.py)."""
    if kind not in _BY_TEXT:
        _BY_TEXT[kind] = _numba_type(kind)
    return _BY_TEXT[kind]


def _numba_type(kind: Any) -> Any:
    if isinstance(kind, StructureOf):
        return StructureType(kind)
    if isinstance(kind, ArrayOf):
        number = from_dtype(np.dtype(kind.code))
        return types.Array(number, kind.ndim, kind.layout, readonly=not kind.mutable)
    if isinstance(kind, TupleOf):
        parts = [numba_type(part) for part in kind.parts]
        return types.BaseTuple.from_types(parts, class_named(kind.name) if kind.name else None)
    if kind.code == "n":
        return types.none
    return types.boolean if kind.code == "b1" else from_dtype(np.dtype(kind.code))


def text_of(kind: Any) -> str:
    """Return the text of one of Numba's types.

    Raises TypeError : a type that has none
    """
    kind = types.unliteral(kind)
    if isinstance(kind, StructureType):
        return kind.text
    if isinstance(kind, types.Array):
        return text_of_array(_code(kind.dtype), kind.ndim, kind.layout, mutable=kind.mutable)
    if isinstance(kind, types.BaseTuple):
        cls = getattr(kind, "instance_class", tuple)
        name = "" if cls is tuple else f"{cls.__module__}:{cls.__qualname__}"
        return text_of_tuple(map(text_of, kind.types), name)
    return repr("n" if kind is types.none else _code(kind))


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
    """Return an array of data and lengths; strides are those of layout C if not given.

    Parameters
    ----------
    context : Numba's context of our compilations
    builder : builder of LLVM instructions
    kind : Numba type of the array
    data : address of its first number
    shape : lengths of its axes
    strides : bytes from entry to entry of each axis
    """
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
        """Key by which this type differs from others."""
        return self.part

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call; compile or load what is called.

        Parameters
        ----------
        context : Numba's typing context
        args : Numba types of the arguments
        kws : arguments by keyword: none are allowed
        """
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
        unit = part.unit(text_of_tuple(map(text_of, kinds)))
        result = numba_type(parse(unit.result))

        def code(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            context.active_code_library.needed[unit.symbol] = unit
            return _call_unit(context, builder, sig, arguments, unit.symbol)

    define(code, key, kinds)
    _results[key] = result
    return result


def unit_type(context: Any, kinds: tuple[Any, ...], result: Any) -> Any:
    """Return the type of a unit, as LLVM sees it.

    Parameters
    ----------
    context : Numba's context of our compilations
    kinds : Numba types of the arguments
    result : Numba type of the result
    """
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
    """Return the values by which one argument is handed over.

    Parameters
    ----------
    context : Numba's context of our compilations
    builder : builder of LLVM instructions
    kind : Numba type of the argument
    value : the argument, as Numba holds it
    """
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
    """Return the argument that the next of `values` (an iterator) hand over.

    Parameters
    ----------
    context : Numba's context of our compilations
    builder : builder of LLVM instructions
    kind : Numba type of the argument
    values : iterator over the values of all arguments, as `flattened` gives them
    """
    if isinstance(kind, types.Array):
        data = next(values)
        shape = [next(values) for _ in range(kind.ndim)]
        strides = None if kind.layout == "C" else [next(values) for _ in range(kind.ndim)]
        return whole_array(context, builder, kind, data, shape, strides)
    if isinstance(kind, types.BaseTuple):
        parts = [whole(context, builder, part, values) for part in kind.types]
        return context.make_tuple(builder, kind, parts)
    return next(values)


_RAISED = "plymotion_raised"  # called where code may raise: no part does


def compiled_unit(part: Part, text: str, symbol: str) -> tuple[str, bytes, dict[str, object]]:
    """Return the result's type, the object code and the needs of a part for arguments of `text`.

    Parameters
    ----------
    part : function to compile
    text : types of its arguments (entry_points.py)
    symbol : name of the unit in the object code

    Raises RuntimeError : code that may raise, or needs what no library has
    """
    kinds = tuple(numba_type(kind) for kind in parse_all(text))
    with global_compiler_lock, fast_compilation():
        lowered = lower(part, kinds)
        context = CONTEXT
        module = context.codegen()._create_empty_module("unit")
        function = ir.Function(module, unit_type(context, kinds, lowered.result), symbol)
        builder = ir.IRBuilder(function.append_basic_block())
        values = iter(function.args)
        arguments = [whole(context, builder, kind, values) for kind in kinds]
        inner = context.declare_function(module, lowered.description)
        status, result = context.call_conv.call_function(
            builder, inner, lowered.result, kinds, arguments
        )
        raised = ir.Function(module, ir.FunctionType(ir.VoidType(), []), _RAISED)
        with builder.if_then(status.is_error, likely=False):
            builder.call(raised, [])
        if lowered.result is types.none:
            builder.ret_void()
        else:
            builder.ret(result)
        texts = [str(module), *lowered.modules.all_texts()]
        code, symbols = machine.emitted(texts, symbol)
    units = lowered.modules.all_needed()
    needs = [
        [units[name].part.name, units[name].arguments, units[name].result]
        for name in symbols
        if name in units
    ]
    others = [name for name in symbols if name not in units]
    for name in others:
        if name == _RAISED:
            raise RuntimeError(f"{part.name}: compiled code cannot raise errors")
        if not machine.available(name):
            raise RuntimeError(f"{part.name}: needs {name}, which no library has")
    return text_of(lowered.result), code, {"units": needs, "symbols": others}


def compiled_door(text: str, result: str, symbol: str, door: str) -> bytes:
    """Return object code of the way from Python to a unit: void door(arguments, results).

    Both point to 8-byte words: a number, the address of a structure's table, the address of an
    array object; a complex number takes two. Results are the numbers in order.

    Parameters
    ----------
    text : types of the arguments (entry_points.py)
    result : type of the result
    symbol : name of the unit that is called
    door : name of the entry point that is made
    """
    kinds = tuple(numba_type(kind) for kind in parse_all(text))
    back = numba_type(parse(result))
    context = CONTEXT
    with global_compiler_lock:
        context.refresh()
        module = context.codegen()._create_empty_module("door")
        function = ir.Function(
            module, ir.FunctionType(ir.VoidType(), [_WORD.as_pointer()] * 2), door
        )
        builder = ir.IRBuilder(function.append_basic_block())
        words, at, flat = function.args[0], 0, []
        for kind in kinds:
            value = _from_word(context, builder, kind, _word(builder, words, at))
            flat += flattened(context, builder, kind, value)
            at += 2 if isinstance(kind, types.Complex) else 1
        unit = ir.Function(module, unit_type(context, kinds, back), symbol)
        result_value = builder.call(unit, flat)
        if back is not types.none:
            _put_words(context, builder, back, result_value, function.args[1], 0)
        builder.ret_void()
        code, _ = machine.emitted([str(module)], door)
    return code


def _word(builder: Any, words: Any, at: int) -> Any:
    return builder.gep(words, [ir.Constant(ir.IntType(32), at)])


def _from_word(context: Any, builder: Any, kind: Any, place: Any) -> Any:
    if isinstance(kind, types.Array):
        # the head of NumPy's array object, checked in entry_points.py
        item = builder.inttoptr(builder.load(place), _WORD.as_pointer())
        data = builder.load(_word(builder, item, 2))
        data = builder.inttoptr(data, context.get_data_type(kind.dtype).as_pointer())
        lengths = []
        for head in (4, 5):
            numbers = builder.inttoptr(builder.load(_word(builder, item, head)), _WORD.as_pointer())
            lengths.append([builder.load(_word(builder, numbers, k)) for k in range(kind.ndim)])
        strides = None if kind.layout == "C" else lengths[1]
        return whole_array(context, builder, kind, data, lengths[0], strides)
    if isinstance(kind, types.Boolean):
        return builder.icmp_signed("!=", builder.load(place), ir.Constant(_WORD, 0))
    if isinstance(kind, types.Number):
        return builder.load(builder.bitcast(place, context.get_value_type(kind).as_pointer()))
    if isinstance(kind, types.BaseTuple):
        raise TypeError(f"{kind}: no argument for a call from Python")
    return builder.inttoptr(builder.load(place), _POINTER)


def _put_words(context: Any, builder: Any, kind: Any, value: Any, words: Any, at: int) -> int:
    if isinstance(kind, types.BaseTuple):
        for k, part in enumerate(kind.types):
            at = _put_words(context, builder, part, builder.extract_value(value, k), words, at)
        return at
    if isinstance(kind, types.Boolean):
        value = builder.zext(value, _WORD)
    place = builder.bitcast(_word(builder, words, at), value.type.as_pointer())
    builder.store(value, place)
    return at + (2 if isinstance(kind, types.Complex) else 1)
