"""Object code of units."""

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from . import machine, signatures
from .calls import unit_type, whole
from .lowering import fast_compilation, lower
from .numba_types import numba_type, text_of
from .parts import Part

_RAISED = "plymotion_raised"  # called where code may raise: no part does


def compiled_unit(part: Part, text: str, symbol: str) -> tuple[str, bytes, dict[str, Any]]:
    """Return the result's type, the object code and the needs of a part for arguments of `text`.

    Raises RuntimeError : code that may raise, or needs what no library has
    """
    kinds = tuple(numba_type(kind) for kind in signatures.parse_all(text))
    with global_compiler_lock, fast_compilation():
        lowered = lower(part, kinds)
        context = cpu_target.target_context
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
