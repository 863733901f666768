"""Names of a package that are imported when they are asked for (PEP 562)."""

from collections.abc import Callable
from importlib import import_module
from typing import Any


def lazy_names(
    modules: dict[str, str], space: dict[str, Any]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package.

    Parameters
    ----------
    modules : public name -> module of the package's folder that has it
    space : `globals()` of the package, which keeps what was asked for
    """
    package = space["__name__"]

    def found(name: str) -> object:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        space[name] = getattr(import_module(f"{package}.{modules[name]}"), name)
        return space[name]

    def names() -> list[str]:
        return sorted([*space, *modules])

    return found, names
