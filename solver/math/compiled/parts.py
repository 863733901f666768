"""Functions that are compiled: units by themselves, inlined ones with each unit that calls them."""

import functools
import inspect
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

from . import content, doors, signatures, store
from .statistics import statistics
from .versions import check_choice, check_versions

# Sums may be reordered and products contracted; inf and nan keep their meaning.
FAST_MATH = {"reassoc", "contract", "nsz", "arcp"}


class Unit(NamedTuple):
    """Machine code of one part for one set of argument types, loaded."""

    part: "Part"
    arguments: str  # types, as text (signatures.py)
    result: str
    symbol: str


_parts: dict[str, "Part"] = {}


class Part:
    """A function of numbers, arrays and structures that is compiled where it is first called.

    Called from Python it runs as compiled code if its arguments are of kinds that compiled code
    can be given, and as plain Python otherwise.
    """

    def __init__(self, function: Callable[..., Any], *, inline: bool) -> None:
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
            door = self._doors[kinds] = self._door(arguments, kinds)
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

    def _door(self, arguments: tuple[Any, ...], kinds: Any) -> Callable[..., Any]:
        """Return what takes words and arguments of such kinds to compiled code."""
        text = None if kinds is None else doors.text(arguments)
        if text is None or len(arguments) != self.function.__code__.co_argcount:
            return lambda words, arguments: self.function(*arguments)
        try:
            check_choice()
            unit = self.unit(text)
            address = self._door_address(unit)
        except Exception as error:
            return self._fallback(error)
        return doors.door(address, signatures.parse_all(text), signatures.parse(unit.result))

    def _fallback(self, error: Exception) -> Callable[..., Any]:
        """Return what calls the function as numba.njit compiles it."""
        from . import fallback

        statistics.fallbacks.append(self.name)
        if len(statistics.fallbacks) == 1:
            warnings.warn(
                f"{self.name}: {error}\nnumba.njit compiles it instead, which takes minutes.",
                RuntimeWarning,
                stacklevel=5,
            )
        dispatcher = fallback.dispatcher(self)
        return lambda words, arguments: dispatcher(*arguments)

    def unit(self, text: str) -> Unit:
        """Return the unit for argument types, compiled or from the cache, and loaded."""
        found = self._units.get(text)
        if found is None:
            found = self._units[text] = self._load(text) or self._compile(text)
        return found

    def _symbol(self, text: str) -> str:
        return f"plymotion_{content.digest(self.name, text)}"

    def _key(self, text: str, purpose: str = "unit") -> str:
        return content.digest(purpose, self.name, self.content(), text, content.environment())

    def _load(self, text: str) -> Unit | None:
        """Load a unit from the cache, after what it needs; None if it is not there."""
        from . import machine

        kept = store.read(self._key(text))
        if kept is None:
            return None
        description, code = kept
        for name, arguments, result in description["units"]:
            if name not in _parts or _parts[name].unit(arguments).result != result:
                return None
        if not all(machine.available(symbol) for symbol in description["symbols"]):
            return None
        machine.load(code, self._symbol(text))
        statistics.loaded.append(self.name)
        return Unit(self, text, description["result"], self._symbol(text))

    def _compile(self, text: str) -> Unit:
        from . import building, machine

        check_versions()
        symbol = self._symbol(text)
        result, code, needs = building.compiled_unit(self, text, symbol)
        machine.load(code, symbol)
        statistics.compiled.append(self.name)
        description = {"name": self.name, "result": result, **needs}
        statistics.kept &= store.write(self._key(text), description, code)
        return Unit(self, text, result, symbol)

    def _door_address(self, unit: Unit) -> int:
        """Return the address of a unit's door for Python."""
        from . import machine

        door = f"{unit.symbol}_door"
        key = content.digest("door", unit.symbol, unit.result, content.environment())
        kept = store.read(key)
        if kept is not None:
            return machine.load(kept[1], door)
        from . import door_code

        code = door_code.compiled_door(unit.arguments, unit.result, unit.symbol, door)
        store.write(key, {"name": f"{self.name} from Python"}, code)
        return machine.load(code, door)


def part_named(name: str) -> Part | None:
    """Return a part by its name."""
    return _parts.get(name)
