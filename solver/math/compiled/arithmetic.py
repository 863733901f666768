"""Arithmetic inside compiled parts that takes the place of Numba's own.

Numba compiles a function for each operation on complex numbers, for `min`, `max` and powers of
integers, links it with every caller, and raises an error where a division is by zero, whatever the
error model. These are a few instructions each, and only the context of our own compilations
(lowering.py) knows them.
"""

from typing import Any

from numba.core.imputils import impl_ret_untracked


def lesser(a: Any, b: Any) -> Any:
    """Return the lesser of two numbers, the first if one is nan."""
    return b if b < a else a


def least(a: Any, b: Any, c: Any) -> Any:
    """Return the least of three numbers."""
    return min(min(a, b), c)


def larger(a: Any, b: Any) -> Any:
    """Return the larger of two numbers, the first if one is nan."""
    return b if b > a else a


def largest(a: Any, b: Any, c: Any) -> Any:
    """Return the largest of three numbers."""
    return max(max(a, b), c)


def power(base: Any, exponent: Any) -> Any:
    """Return a number raised to an integer; inf for a negative power of zero."""
    n, square, found = exponent if exponent > 0 else -exponent, base, 1.0
    while n != 0:
        if n & 1:
            found *= square
        n >>= 1
        square *= square
    return found if exponent >= 0 else 1.0 / found


def _parts(context: Any, builder: Any, sig: Any, arguments: Any) -> list[Any]:
    pairs = zip(sig.args, arguments, strict=True)
    return [context.make_complex(builder, kind, value) for kind, value in pairs]


def _made(context: Any, builder: Any, kind: Any, real: Any, imag: Any) -> Any:
    made = context.make_complex(builder, kind)
    made.real, made.imag = real, imag
    return impl_ret_untracked(context, builder, kind, made._getvalue())


def multiply(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    """Multiply, as Numba does: inf and nan are those of the sums and products."""
    a, b = _parts(context, builder, sig, arguments)
    real = builder.fsub(builder.fmul(a.real, b.real), builder.fmul(a.imag, b.imag))
    imag = builder.fadd(builder.fmul(a.real, b.imag), builder.fmul(a.imag, b.real))
    return _made(context, builder, sig.return_type, real, imag)


def divide(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    """Divide by Smith's method; by zero: inf or nan, as NumPy does."""
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
    """Take the root of the squares: of numbers below 1e154, which no unit exceeds."""
    (a,) = _parts(context, builder, sig, arguments)
    square = builder.fadd(builder.fmul(a.real, a.real), builder.fmul(a.imag, a.imag))
    root = builder.module.declare_intrinsic("llvm.sqrt", [square.type])
    return impl_ret_untracked(context, builder, sig.return_type, builder.call(root, [square]))
