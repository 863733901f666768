"""What the files of a folder supply: one file adds one thing, and no list names it again."""

import pkgutil
from collections.abc import Collection, Iterable
from importlib import import_module
from typing import TypeVar

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
    found: list[Thing] = []
    for module in sorted({info.name for info in pkgutil.iter_modules(list(path))} - {*besides}):
        for value in vars(import_module(f"{package}.{module}")).values():
            if isinstance(value, kind) and not any(value is other for other in found):
                found.append(value)
    return found


def listed(named: Iterable[tuple[str, Thing]], names: Iterable[str], what: str) -> dict[str, Thing]:
    """Return things by name in the order of a list kept elsewhere.

    Raises ValueError : things and list differ.
    """
    found, names = by_name(named, what), list(names)
    if set(found) != set(names):
        raise ValueError(f"{what}: the files supply {sorted(found)}, the list has {sorted(names)}")
    return {name: found[name] for name in names}


def by_name(named: Iterable[tuple[str, Thing]], what: str) -> dict[str, Thing]:
    """Return a table of things by name; raises ValueError for a name that occurs twice."""
    table: dict[str, Thing] = {}
    for name, thing in named:
        if name in table:
            raise ValueError(f"{what} {name!r} is defined twice")
        table[name] = thing
    return table
