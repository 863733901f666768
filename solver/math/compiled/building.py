"""Object code of units, and of their entry points from Python (doors.py)."""

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.compiler_lock import global_compiler_lock

from . import machine, signatures
from .calls import flattened, numba_type, text_of, unit_type, whole, whole_array
from .lowering import CONTEXT, fast_compilation, lower
from .parts import Part

_POINTER = ir.IntType(8).as_pointer()
_WORD = ir.IntType(64)

_RAISED = "plymotion_raised"  # called where code may raise: no part does


def compiled_unit(part: Part, text: str, symbol: str) -> tuple[str, bytes, dict[str, Any]]:
    """Return the result's type, the object code and the needs of a part for arguments of `text`.

    Raises RuntimeError : code that may raise, or needs what no library has
    """
    kinds = tuple(numba_type(kind) for kind in signatures.parse_all(text))
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
    """
    kinds = tuple(numba_type(kind) for kind in signatures.parse_all(text))
    back = numba_type(signatures.parse(result))
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
        found = builder.call(unit, flat)
        if back is not types.none:
            _put_words(context, builder, back, found, function.args[1], 0)
        builder.ret_void()
        code, _ = machine.emitted([str(module)], door)
    return code


def _word(builder: Any, words: Any, at: int) -> Any:
    return builder.gep(words, [ir.Constant(ir.IntType(32), at)])


def _from_word(context: Any, builder: Any, kind: Any, place: Any) -> Any:
    if isinstance(kind, types.Array):
        # the head of NumPy's array object, checked in doors.py
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
