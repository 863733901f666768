"""Units of parts, loaded from the cache or compiled and stored there; their entry points."""

import time
import warnings
from collections.abc import Callable
from typing import Any

from . import content, doors, signatures, store
from .parts import Part, Unit, part_named
from .statistics import statistics
from .versions import check_choice, check_versions, import_numba


def unit(part: Part, text: str) -> Unit:
    """Return the unit of a part for argument types, loaded."""
    return _loaded(part, text) or _compiled(part, text)


def door(part: Part, arguments: tuple[Any, ...], kinds: Any) -> Callable[..., Any]:
    """Return what takes words and arguments of such kinds to compiled code."""
    begin = time.process_time()
    try:
        return _door(part, arguments, kinds)
    finally:
        statistics.load_s += time.process_time() - begin


def _door(part: Part, arguments: tuple[Any, ...], kinds: Any) -> Callable[..., Any]:
    text = None if kinds is None else doors.text(arguments)
    if text is None or len(arguments) != part.function.__code__.co_argcount:
        return lambda words, arguments: part.function(*arguments)
    try:
        check_choice()
        found = part.unit(text)
        address = _door_address(found)
    except Exception as error:
        return _fallback(part, error)
    return doors.door(address, signatures.parse_all(text), signatures.parse(found.result))


def _fallback(part: Part, error: Exception) -> Callable[..., Any]:
    """Return what calls the function as numba.njit compiles it."""
    from . import fallback

    statistics.fallbacks.append(part.name)
    if len(statistics.fallbacks) == 1:
        warnings.warn(
            f"{part.name}: {error}\nnumba.njit compiles it instead, which takes minutes.",
            RuntimeWarning,
            stacklevel=4,
        )
    dispatcher = fallback.dispatcher(part)
    return lambda words, arguments: dispatcher(*arguments)


def _symbol(part: Part, text: str) -> str:
    return f"plymotion_{content.digest(part.name, text)}"


def _key(part: Part, text: str) -> str:
    return content.digest(part.name, part.content(), text, content.environment())


def _loaded(part: Part, text: str) -> Unit | None:
    """Load a unit from the cache, after what it needs; None if it is not there."""
    from . import machine

    kept = store.read(_key(part, text))
    if kept is None:
        return None
    description, code = kept
    for name, arguments, result in description["units"]:
        needed = part_named(name)
        if needed is None or needed.unit(arguments).result != result:
            return None
    if not all(machine.available(symbol) for symbol in description["symbols"]):
        return None
    machine.load(code, _symbol(part, text))
    statistics.loaded.append(part.name)
    return Unit(part, text, description["result"], _symbol(part, text))


def _compiled(part: Part, text: str) -> Unit:
    check_versions()
    import_numba()
    from . import building, machine

    symbol = _symbol(part, text)
    result, code, needs = building.compiled_unit(part, text, symbol)
    machine.load(code, symbol)
    statistics.compiled.append(part.name)
    description = {"name": part.name, "result": result, **needs}
    statistics.kept &= store.write(_key(part, text), description, code)
    return Unit(part, text, result, symbol)


def _door_address(found: Unit) -> int:
    """Return the address of a unit's door for Python."""
    from . import machine

    symbol = f"{found.symbol}_door"
    key = content.digest("door", found.symbol, found.result, content.environment())
    kept = store.read(key)
    if kept is not None:
        return machine.load(kept[1], symbol)
    import_numba()
    from . import door_code

    code = door_code.compiled_door(found.arguments, found.result, found.symbol, symbol)
    store.write(key, {"name": f"{found.part.name} from Python"}, code)
    return machine.load(code, symbol)
