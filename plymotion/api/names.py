"""Things by name, with a message that suggests the nearest name."""

from collections.abc import Iterator, Mapping
from typing import Generic, TypeVar

from ..solver.errors import InputError, nearest
from .html import table

T = TypeVar("T")


class UnknownName(KeyError, InputError):
    """A name that does not exist; the message has the nearest one that does."""

    def __str__(self) -> str:
        return str(self.args[0])


class ByName(Mapping[str, T], Generic[T]):
    """A mapping that cannot be changed; an unknown name is a KeyError with a suggestion.

    Parameters
    ----------
    what : word for messages: "signals"
    items : in order

    Examples
    --------
    >>> import plymotion as pm
    >>> signals = pm.run("pendulum.toml").signals
    >>> list(signals), "tip_x" in signals
    (['angle', 'tip_x', 'tip_z'], True)
    """

    def __init__(self, what: str, items: Mapping[str, T]) -> None:
        self._what, self._items = what, dict(items)

    def __getitem__(self, name: str) -> T:
        try:
            return self._items[name]
        except KeyError:
            hint = nearest(str(name), self._items)
            raise UnknownName(f"no {name!r} among the {self._what}{hint}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __repr__(self) -> str:
        return f"<{len(self)} {self._what}: {', '.join(self)}>"

    def _repr_html_(self) -> str:
        return table([self._what, ""], [[name, repr(item)] for name, item in self.items()])
