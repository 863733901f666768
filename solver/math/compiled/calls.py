"""Calls between parts: how arguments are handed over, and the code of a call.

A unit takes an array of layout C as its address and lengths; others with their strides as well.
"""

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import lower_constant
from numba.core.registry import cpu_target
from numba.core.typing.templates import signature
from numba.extending import register_model, typeof_impl
from numba.np import arrayobj

from . import signatures
from .lowering import lower
from .numba_types import numba_type, text_of, whole_array
from .parts import Part

_WORD = ir.IntType(64)

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

    cpu_target.target_context.insert_func_defn([(code, key, kinds)])
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
