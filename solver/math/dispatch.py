"""A function that calls one of several by number, in a form that Numba compiles.

Numba compiles a chain of direct calls well and a call through a list of functions badly or not
at all. The chain is generated, so that a new kernel needs no edit of the function that calls it.
Used below `@jit` (math/compiled.py).
"""

import ast
import inspect
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])
Call = tuple[Callable[..., Any], Sequence[str]]


def dispatched(on: str, calls: Sequence[Call]) -> Callable[[Function], Function]:
    """Replace the body of a function by calls: the n-th of `calls` where argument `on` equals n.

    The last one is called for any other number too. The function keeps its name, arguments and
    docstring; its code depends on `calls` alone. Tracebacks show the line of its definition.

    Parameters
    ----------
    on : name of an argument, an integer
    calls : functions with names that differ, and their arguments as expressions of the function's
        own arguments

    Raises
    ------
    ValueError
        No function to call, or two of one name.
    """
    names = [call.__name__ for call, _ in calls]
    if not names or len(set(names)) < len(names):
        raise ValueError(f"expected functions with names that differ, got {names}")

    def decorate(function: Function) -> Function:
        own = ", ".join(inspect.signature(function).parameters)
        lines = [f"def {function.__name__}({own}):"]
        for number, (name, (_, arguments)) in enumerate(zip(names, calls, strict=True)):
            call = f"return {name}({', '.join(arguments)})"
            last = number == len(names) - 1
            lines.append(f"    {call}" if last else f"    if {on} == {number}: {call}")
        code = function.__code__
        tree = ast.parse("\n".join(lines))
        for node in ast.walk(tree):
            if isinstance(node, ast.stmt | ast.expr | ast.arg):
                node.lineno = node.end_lineno = code.co_firstlineno
        space: dict[str, Any] = {name: call for name, (call, _) in zip(names, calls, strict=True)}
        space["__name__"] = function.__module__
        exec(compile(tree, code.co_filename, "exec"), space)
        made: Function = space[function.__name__]
        made.__doc__ = function.__doc__
        return made

    return decorate
