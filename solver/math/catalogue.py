"""What the files of a folder supply: one file adds one thing, and no list names it again.

Such a file may declare keys of an input file, as plain data. `dispatched` calls the functions of
the files by number; `lazy_names` imports the modules of a package when their names are asked for.
"""

import ast
import pkgutil
from collections.abc import Callable, Collection, Iterable, Sequence
from importlib import import_module
from typing import Any, Literal, NamedTuple, TypeVar

Thing = TypeVar("Thing")


def catalogue(
    package: str, path: Iterable[str], kind: type[Thing], besides: Collection[str] = ()
) -> list[Thing]:
    """Return the objects of type `kind` at the top level of a package's modules.

    Modules are imported in the order of their names; an object counts in the module that makes
    it and once, however many others import it.

    Parameters
    ----------
    package, path : `__name__` and `__path__` of the package
    besides : modules that supply nothing and are not imported
    """
    things: list[Thing] = []
    for module in sorted({info.name for info in pkgutil.iter_modules(list(path))} - {*besides}):
        for value in vars(import_module(f"{package}.{module}")).values():
            if isinstance(value, kind) and not any(value is other for other in things):
                things.append(value)
    return things


def listed(things: Iterable[Thing], names: Iterable[str], what: str) -> dict[str, Thing]:
    """Return things by name in the order of a list kept elsewhere.

    Parameters
    ----------
    things : those of the files, each with its `name`
    names : the list, in its order
    what : the word for such things in messages

    Raises
    ------
    ValueError : things and list differ.
    """
    by_names = by_name(((vars(thing)["name"], thing) for thing in things), what)
    names = list(names)
    if set(by_names) != set(names):
        raise ValueError(
            f"{what}: the files supply {sorted(by_names)}, the list has {sorted(names)}"
        )
    return {name: by_names[name] for name in names}


def argument_names(function: Callable[..., Any]) -> tuple[str, ...]:
    """Return the names of the arguments of a function or kernel: inspect.signature takes ms."""
    code = getattr(function, "py_func", function).__code__
    return tuple(code.co_varnames[: code.co_argcount])


def by_name(named: Iterable[tuple[str, Thing]], what: str) -> dict[str, Thing]:
    """Return a table of things by name; raises ValueError for a name that occurs twice."""
    table: dict[str, Thing] = {}
    for name, thing in named:
        if name in table:
            raise ValueError(f"{what} {name!r} is defined twice")
        table[name] = thing
    return table


class Number(NamedTuple):
    """A number: a key of the case file, and an argument of what the kind supplies."""

    name: str
    unit: str
    meaning: str  # one line
    required: bool = False
    default: float | None = None  # None: the file of the kind finds it
    above: float | None = None  # bounds: above, or from `least` on; up to `most`
    least: float | None = None
    most: float | None = None
    not_zero: bool = False
    integer: bool = False


class Three(NamedTuple):
    """Three numbers, 0 or above, along or about the axes of marker one."""

    name: str
    unit: str
    meaning: str  # one line
    required: bool = False  # else: zeros


class Direction(NamedTuple):
    """A global direction at the start."""

    name: Literal["axis", "axis_1", "axis_2"]
    meaning: str  # one line
    required: bool = False  # else: global z
    absent: bool = False  # may be absent, without default


class Expression(NamedTuple):
    """An expression of a case (math/expressions/parse.py)."""

    name: str
    unit: str
    meaning: str  # one line
    required: bool = False
    default: str | None = None


class Expressions(NamedTuple):
    """Several expressions; required."""

    name: str
    meaning: str  # one line


class Code(NamedTuple):
    """A function in a Python file; required."""

    name: str
    meaning: str  # one line


class Curve(NamedTuple):
    """Points of a curve y(x)."""

    name: str
    unit: str
    meaning: str  # one line


class OfTime(NamedTuple):
    """The law of time of a force or torque; may be absent."""

    name: str
    meaning: str  # one line


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
        own = ", ".join(argument_names(function))
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


def lazy_names(
    public: dict[str, tuple[str, ...]], space: dict[str, object]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package.

    Parameters
    ----------
    public : module of the package's folder -> the names that it offers
    space : `globals()` of the package, which keeps what was asked for
    """
    package = space["__name__"]
    modules = {name: module for module, names in public.items() for name in names}

    def value_of(name: str) -> object:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        space[name] = getattr(import_module(f"{package}.{modules[name]}"), name)
        return space[name]

    def names() -> list[str]:
        return sorted([*space, *modules])

    return value_of, names
