"""Functions that are compiled: units by themselves, inlined ones with each unit that calls them."""

import functools
import inspect
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from . import content, doors

# Sums may be reordered and products contracted; inf and nan keep their meaning.
FAST_MATH = {"reassoc", "contract", "nsz", "arcp"}


class Statistics:
    """What this process has compiled or loaded: names, once for each set of argument types."""

    def __init__(self) -> None:
        self.compiled: list[str] = []
        self.loaded: list[str] = []
        self.fallbacks: list[str] = []  # compiled by numba.njit
        self.kept = True  # the cache could be written
        self.load_s = 0.0  # CPU time for all of them


statistics = Statistics()


class Unit(NamedTuple):
    """Machine code of one part for one set of argument types, loaded."""

    part: "Part"
    arguments: str  # types, as text (signatures.py)
    result: str
    symbol: str


class Service(Protocol):
    """What makes machine code of parts."""

    def unit(self, part: "Part", text: str) -> Unit:
        """Return the unit of a part for argument types."""

    def door(self, part: "Part", arguments: Any, kinds: Any) -> Callable[..., Any]:
        """Return what takes words and arguments of such kinds to compiled code."""


_parts: dict[str, "Part"] = {}


class Part:
    """A function of numbers, arrays and structures that is compiled where it is first called.

    Called from Python it runs as compiled code if its arguments are of kinds that compiled code
    can be given, and as plain Python otherwise.

    Parameters
    ----------
    inline : it becomes code of its callers
    service : compiles and loads (units.py)
    """

    def __init__(
        self, function: Callable[..., Any], *, inline: bool, service: Service | None = None
    ) -> None:
        self._service: Any = service
        self.function = self.__wrapped__ = function
        self.inline = inline
        functools.update_wrapper(self, function)
        name, count = f"{function.__module__}:{function.__qualname__}", 1
        while name in _parts:  # of functions made in a loop, say
            count += 1
            name = f"{function.__module__}:{function.__qualname__}#{count}"
        self.name = name
        _parts[name] = self
        self._units: dict[str, Unit] = {}
        self._doors: dict[Any, Any] = {}
        self._content = ""
        self.others: dict[int, Part] = {}  # of the same name, by number of arguments

    def of_count(self, count: int) -> "Part | None":
        """Return the part that takes so many arguments."""
        own = self.function.__code__.co_argcount == count
        return self if own else self.others.get(count)

    @property
    def py_func(self) -> Callable[..., Any]:
        """The function itself."""
        return self.function

    def __reduce__(self) -> str:
        return str(self.function.__qualname__)

    def __repr__(self) -> str:
        return f"<compiled {self.name}>"

    def __call__(self, *arguments: Any, **keywords: Any) -> Any:
        """Call compiled code; compile it first if need be."""
        if keywords:
            arguments = inspect.signature(self.function).bind(*arguments, **keywords).args
        kinds, words = doors.described(arguments)
        door = self._doors.get(kinds)
        if door is None:
            door = self._doors[kinds] = self._service.door(self, arguments, kinds)
        return door(words, arguments)

    def content(self) -> str:
        """Return the digest of the function and what it takes in."""
        if not self._content:
            self._content = "recursive"
            self._content = content.content(self.function)
        return self._content

    def content_as_callee(self) -> str:
        """Return what enters the digest of callers."""
        return f"inlined {self.content()}" if self.inline else f"unit {self.name}"

    def unit(self, text: str) -> Unit:
        """Return the unit for argument types, compiled or from the cache, and loaded."""
        found = self._units.get(text)
        if found is None:
            found = self._units[text] = self._service.unit(self, text)
        return found


def part_named(name: str) -> Part | None:
    """Return a part by its name."""
    return _parts.get(name)
