"""Parts in LLVM's language: Numba's passes up to there, with what belongs to the result.

Some arithmetic takes the place of Numba's own. Numba compiles a function for each operation on
complex numbers, for `min`, `max` and powers of integers, links it with every caller, and raises an
error where a division is by zero, whatever the error model. Ours are a few instructions each, and
only the context of our own compilations knows them.
"""

import copy
import gc
import operator
from collections.abc import Iterator
from contextlib import contextmanager
from types import FunctionType
from typing import Any, NamedTuple

from numba.core import types
from numba.core.base import OverloadSelector, _wrap_impl
from numba.core.codegen import CodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags, compile_extra
from numba.core.cpu import CPUContext, FastMathOptions
from numba.core.errors import NumbaNotImplementedError
from numba.core.imputils import impl_ret_untracked
from numba.core.registry import cpu_target
from numba.np import arrayobj

from .parts import FAST_MATH, Part, Unit


def lesser(a: Any, b: Any) -> Any:
    """Return the lesser of two numbers, the first if one is nan."""
    return b if b < a else a


def least(a: Any, b: Any, c: Any) -> Any:
    """Return the least of three numbers.

    Parameters
    ----------
    a : first number
    b : second number
    c : third number
    """
    return min(min(a, b), c)


def larger(a: Any, b: Any) -> Any:
    """Return the larger of two numbers, the first if one is nan."""
    return b if b > a else a


def largest(a: Any, b: Any, c: Any) -> Any:
    """Return the largest of three numbers.

    Parameters
    ----------
    a : first number
    b : second number
    c : third number
    """
    return max(max(a, b), c)


def power(base: Any, exponent: Any) -> Any:
    """Return a number raised to an integer; inf for a negative power of zero."""
    n, square, product = exponent if exponent > 0 else -exponent, base, 1.0
    while n != 0:
        if n & 1:
            product *= square
        n >>= 1
        square *= square
    return product if exponent >= 0 else 1.0 / product


def _parts(context: Any, builder: Any, sig: Any, arguments: Any) -> list[Any]:
    pairs = zip(sig.args, arguments, strict=True)
    return [context.make_complex(builder, kind, value) for kind, value in pairs]


def _made(context: Any, builder: Any, kind: Any, real: Any, imag: Any) -> Any:
    made = context.make_complex(builder, kind)
    made.real, made.imag = real, imag
    return impl_ret_untracked(context, builder, kind, made._getvalue())


def multiply(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    """Multiply, as Numba does: inf and nan are those of the sums and products.

    Parameters
    ----------
    context : Numba's context of our compilations
    builder : builder of LLVM instructions
    sig : types of both factors and of the product
    arguments : both factors
    """
    a, b = _parts(context, builder, sig, arguments)
    real = builder.fsub(builder.fmul(a.real, b.real), builder.fmul(a.imag, b.imag))
    imag = builder.fadd(builder.fmul(a.real, b.imag), builder.fmul(a.imag, b.real))
    return _made(context, builder, sig.return_type, real, imag)


def divide(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    """Divide by Smith's method; by zero: inf or nan, as NumPy does.

    Parameters
    ----------
    context : Numba's context of our compilations
    builder : builder of LLVM instructions
    sig : types of both numbers and of the quotient
    arguments : numerator, denominator
    """
    a, b = _parts(context, builder, sig, arguments)
    size = builder.module.declare_intrinsic("llvm.fabs", [b.real.type])
    swap = builder.fcmp_ordered("<", builder.call(size, [b.real]), builder.call(size, [b.imag]))
    p, q = builder.select(swap, b.imag, b.real), builder.select(swap, b.real, b.imag)
    x, y = builder.select(swap, a.imag, a.real), builder.select(swap, a.real, a.imag)
    ratio = builder.fdiv(q, p)
    whole = builder.fadd(p, builder.fmul(q, ratio))
    real = builder.fdiv(builder.fadd(x, builder.fmul(y, ratio)), whole)
    imag = builder.fdiv(builder.fsub(y, builder.fmul(x, ratio)), whole)
    return _made(
        context, builder, sig.return_type, real, builder.select(swap, builder.fneg(imag), imag)
    )


def absolute(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    """Take the root of the squares: of numbers below 1e154, which no unit exceeds.

    Parameters
    ----------
    context : Numba's context of our compilations
    builder : builder of LLVM instructions
    sig : types of the number and of the result
    arguments : the complex number
    """
    (a,) = _parts(context, builder, sig, arguments)
    square = builder.fadd(builder.fmul(a.real, a.real), builder.fmul(a.imag, a.imag))
    root = builder.module.declare_intrinsic("llvm.sqrt", [square.type])
    return impl_ret_untracked(context, builder, sig.return_type, builder.call(root, [square]))


# Passes for what no part contains: closures, `with`, `raise`, literal loops, reports.
_UNUSED = {
    "WithLifting",
    "InlineClosureLikes",
    "RewriteDynamicRaises",
    "MakeFunctionToJitFunction",
    "InlineInlinables",
    "FindLiterallyCalls",
    "LiteralUnroll",
    "LiteralPropagationSubPipelinePass",
    "InlineOverloads",
    "NoPythonSupportedFeatureValidation",
    "AnnotateTypes",
    "DumpParforDiagnostics",
}


BUILTINS = {
    "min": Part(lesser, inline=True),
    "max": Part(larger, inline=True),
}
BUILTINS["min"].others[3] = Part(least, inline=True)
BUILTINS["max"].others[3] = Part(largest, inline=True)
POWER = Part(power, inline=True)


class _Pipeline(CompilerBase):  # type: ignore[misc]
    """Numba's passes for plain functions of numbers and arrays."""

    def define_pipelines(self) -> list[Any]:
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.passes[:] = [p for p in manager.passes if p[0].__name__ not in _UNUSED]
        manager._finalized = False
        manager.finalize()
        return [manager]


_definitions: dict[Any, Any] = {}  # code of operations and calls that only parts contain


class PartContext(CPUContext):  # type: ignore[misc]
    """Numba's context for this CPU, with operations and calls of parts; it leaves Numba's alone."""

    def get_function(self, fn: Any, sig: Any, _firstcall: bool = True) -> Any:
        """Return what makes the code of a call or an operation.

        Parameters
        ----------
        fn : function or operation that is called
        sig : Numba types of its arguments and result
        _firstcall : passed on to Numba
        """
        key = fn.get_impl_key(sig.as_function()) if isinstance(fn, types.Callable) else fn
        if key in _definitions:
            try:
                return _wrap_impl(_definitions[key].find(sig.args), self, sig.as_function())
            except NumbaNotImplementedError:
                pass  # for other types
        return super().get_function(fn, sig, _firstcall)


def _part_context() -> Any:
    """Return a context that shares what Numba's has, but for the functions it compiles inside."""
    own = copy.copy(cpu_target.target_context)
    own.__class__ = PartContext
    own.cached_internal_func = {}
    return own


CONTEXT = _part_context()


def define(code: Any, key: Any, kinds: tuple[Any, ...]) -> None:
    """Let `code` make the instructions of what `key` stands for, for arguments of these types.

    Parameters
    ----------
    code : function that makes the instructions
    key : function or operation
    kinds : Numba types of its arguments
    """
    _definitions.setdefault(key, OverloadSelector()).append(code, kinds)


class Modules(CodeLibrary):  # type: ignore[misc]
    """Modules of LLVM as Numba makes them, and what they are to be linked with."""

    def __init__(self, name: str) -> None:
        super().__init__(CONTEXT.codegen(), name)
        self.texts: list[str] = []
        self.linked: dict[int, Any] = {}
        self.needed: dict[str, Unit] = {}  # units called, by symbol

    def add_linking_library(self, library: Any) -> None:
        """Note a library whose code is called."""
        self.linked[id(library)] = library

    def add_ir_module(self, ir_module: Any) -> None:
        """Note a module of this function."""
        self.texts.append(str(ir_module))

    def all_texts(self) -> list[str]:
        """Return the modules of this function and of all that becomes part of it."""
        texts_of: dict[int, list[str]] = {}
        self._collect(texts_of)
        return [text for texts in texts_of.values() for text in texts]

    def all_needed(self) -> dict[str, Unit]:
        """Return the units that this function and its parts call."""
        needed = dict(self.needed)
        for library in self.linked.values():
            if isinstance(library, Modules):
                needed |= library.all_needed()
        return needed

    def _collect(self, texts_of: dict[int, list[str]]) -> None:
        if id(self) in texts_of:
            return
        texts_of[id(self)] = self.texts
        for library in self.linked.values():
            if isinstance(library, Modules):
                library._collect(texts_of)
            else:
                texts_of[id(library)] = [library.get_llvm_str()]

    def finalize(self) -> None:
        """Do nothing: machine.py does."""

    def get_function(self, name: str) -> Any:
        """Refuse."""
        raise NotImplementedError

    def get_llvm_str(self) -> str:
        """Return the text of the modules."""
        return "\n".join(self.texts)

    def get_asm_str(self) -> str:
        """Refuse."""
        raise NotImplementedError


class Lowered(NamedTuple):
    """A part in LLVM's language, for one set of argument types."""

    modules: Modules
    description: Any  # Numba's, of the function
    result: Any  # its type


_lowered: dict[Any, Lowered] = {}


_signatures: dict[Any, Any] = {}


def _remembered(self: Any, context: Any, arguments: Any, keywords: Any) -> Any:
    """Return the signature of a call of a function of Numba, searched for once.

    An addition has dozens of candidates, of lists, texts and dates; all are tried every time.
    """
    if keywords:
        return _search(self, context, arguments, keywords)
    key = id(self), tuple(arguments)
    if key not in _signatures:
        _signatures[key] = self, _search(self, context, arguments, keywords)
    return _signatures[key][1]


_search = types.Function.get_call_type


_fix_index = arrayobj.fix_integer_index


def _index_as_it_is(context: Any, builder: Any, kind: Any, index: Any, size: Any) -> Any:
    if not isinstance(context, PartContext):
        return _fix_index(context, builder, kind, index, size)
    return context.cast(builder, index, kind, types.intp if kind.signed else types.uintp)


@contextmanager
def fast_compilation() -> Iterator[None]:
    """No search for garbage, no second search for a signature, no branch for negative indices."""
    # what is called is compiled in the midst of its caller: leave things as they were found
    collecting, fixed = gc.isenabled(), arrayobj.fix_integer_index
    search = types.Function.get_call_type
    gc.disable()
    arrayobj.fix_integer_index = _index_as_it_is
    types.Function.get_call_type = _remembered
    try:
        yield
    finally:
        types.Function.get_call_type = search
        arrayobj.fix_integer_index = fixed
        if collecting:
            gc.enable()


def _flags() -> Any:
    flags = Flags()
    flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    flags.error_model = "numpy"
    flags.fastmath = FastMathOptions(FAST_MATH)
    flags.forceinline = True
    flags.nrt = False
    return flags


def _with_builtins(function: Any) -> Any:
    """Return a function whose `min` and `max` are the parts above."""
    known = BUILTINS | function.__globals__
    return FunctionType(
        function.__code__, known, function.__name__, function.__defaults__, function.__closure__
    )


def lower(part: Part, kinds: tuple[Any, ...]) -> Lowered:
    """Return a part in LLVM's language, for argument types."""
    key = part, kinds
    if key not in _lowered:
        modules = Modules(part.name)
        done = compile_extra(
            cpu_target.typing_context,
            CONTEXT,
            _with_builtins(part.function),
            kinds,
            None,
            _flags(),
            {},
            library=modules,
            pipeline_class=_Pipeline,
        )
        _lowered[key] = Lowered(modules, done.fndesc, done.signature.return_type)
    return _lowered[key]


def _power(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    lowered = lower(POWER, sig.args)
    context.active_code_library.add_linking_library(lowered.modules)
    return context.call_internal(builder, lowered.description, sig, arguments)


_COMPLEX = types.complex128
for _operators, _code, _kinds in (
    ((operator.mul, operator.imul), multiply, (_COMPLEX, _COMPLEX)),
    ((operator.truediv, operator.itruediv), divide, (_COMPLEX, _COMPLEX)),
    ((abs,), absolute, (_COMPLEX,)),
    ((operator.pow, operator.ipow), _power, (types.float64, types.int64)),
):
    for _operator in _operators:
        define(_code, _operator, _kinds)
