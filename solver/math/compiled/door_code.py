"""Object code of the Python entry points of units (doors.py)."""

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from . import machine, signatures
from .calls import flattened, unit_type
from .numba_types import numba_type, whole_array

_POINTER = ir.IntType(8).as_pointer()
_WORD = ir.IntType(64)


def compiled_door(text: str, result: str, symbol: str, door: str) -> bytes:
    """Return object code of the way from Python to a unit: void door(arguments, results).

    Both point to 8-byte words: a number, the address of a structure's table, the address of an
    array object; a complex number takes two. Results are the numbers in order.
    """
    kinds = tuple(numba_type(kind) for kind in signatures.parse_all(text))
    back = numba_type(signatures.parse(result))
    context = cpu_target.target_context
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
