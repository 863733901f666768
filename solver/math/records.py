"""Dataclasses whose methods are closures, where the standard library compiles text for each.

That takes 1 ms for a frozen class, and a run makes seventy classes before it begins.
"""

import dataclasses
from dataclasses import MISSING, FrozenInstanceError, asdict, field, fields, replace
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING

__all__ = ["asdict", "dataclass", "field", "fields", "replace"]

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, *, frozen=False, eq=True, kw_only=False):
        """Make a dataclass, as the decorator of this name in the standard library does."""
        if cls is None:
            return partial(dataclass, frozen=frozen, eq=eq, kw_only=kw_only)
        made = dataclasses.dataclass(cls, init=False, repr=False, eq=False, kw_only=kw_only)
        given = [f for f in fields(made) if f.init]
        names = dict.fromkeys(f.name for f in given).keys()
        positional = [f.name for f in given if not f.kw_only]
        defaults = {f.name: f.default for f in given if f.default is not MISSING}
        factories = {f.name: f.default_factory for f in given if f.default_factory is not MISSING}
        compared = attrgetter(*[f.name for f in fields(made) if f.compare] or ["__class__"])
        post_init = hasattr(made, "__post_init__")

        def __init__(self, *values, **named):
            state, count = self.__dict__, len(values)
            state.update(defaults)
            state.update(zip(positional, values, strict=False))
            state.update(named)
            for name, make in factories.items():
                if name not in state:
                    state[name] = make()
            twice = count and not named.keys().isdisjoint(positional[:count])
            if state.keys() != names or twice or count > len(positional):
                found = ", ".join([f"{count} without names", *named])
                raise TypeError(f"{cls.__name__}: expected {', '.join(names)}; found {found}")
            if post_init:
                self.__post_init__()

        def __eq__(self, other):
            return (
                compared(self) == compared(other) if type(other) is type(self) else NotImplemented
            )

        made.__init__, made.__repr__ = __init__, _text
        if eq:
            made.__eq__ = __eq__
            made.__hash__ = (lambda self: hash(compared(self))) if frozen else None
        if frozen:
            made.__setattr__ = made.__delattr__ = _refuse
        return made


def _text(self: object) -> str:
    parts = [f"{f.name}={getattr(self, f.name)!r}" for f in fields(self)]  # type: ignore[arg-type]
    return f"{type(self).__qualname__}({', '.join(parts)})"


def _refuse(self: object, name: str, value: object = None) -> None:
    raise FrozenInstanceError(f"{type(self).__name__}.{name} cannot be changed or deleted")
