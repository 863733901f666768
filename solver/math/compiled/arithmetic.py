"""Arithmetic of complex numbers as a few instructions.

Numba compiles a function for each, links it with every caller, and raises an error where a
division is by zero, whatever the error model.
"""

import operator
from typing import Any

from numba.core import types
from numba.core.imputils import impl_ret_untracked
from numba.cpython import numbers


def register(context: Any) -> None:
    """Give a target context the functions below, for the one type that they are written for."""
    one = types.complex128
    context.refresh()
    context.insert_func_defn(
        [(_multiply, f, (one, one)) for f in (operator.mul, operator.imul)]
        + [(_divide, f, (one, one)) for f in (operator.truediv, operator.itruediv)]
        + [(_absolute, abs, (one,))]
    )


def _parts(context: Any, builder: Any, sig: Any, arguments: Any) -> list[Any]:
    pairs = zip(sig.args, arguments, strict=True)
    return [context.make_complex(builder, kind, value) for kind, value in pairs]


def _made(context: Any, builder: Any, kind: Any, real: Any, imag: Any) -> Any:
    made = context.make_complex(builder, kind)
    made.real, made.imag = real, imag
    return impl_ret_untracked(context, builder, kind, made._getvalue())


def _multiply(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    a, b = _parts(context, builder, sig, arguments)
    real = builder.fsub(builder.fmul(a.real, b.real), builder.fmul(a.imag, b.imag))
    imag = builder.fadd(builder.fmul(a.real, b.imag), builder.fmul(a.imag, b.real))
    return _made(context, builder, sig.return_type, real, imag)


def _divide(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    """Divide by Smith's method; by zero: inf or nan, as NumPy does."""
    if context.error_model.raise_on_fp_zero_division:
        return numbers.complex_div_impl(context, builder, sig, arguments)
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


def _absolute(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    (a,) = _parts(context, builder, sig, arguments)
    square = builder.fadd(builder.fmul(a.real, a.real), builder.fmul(a.imag, a.imag))
    root = builder.module.declare_intrinsic("llvm.sqrt", [square.type])
    return impl_ret_untracked(context, builder, sig.return_type, builder.call(root, [square]))
