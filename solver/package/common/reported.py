"""Warnings of an analysis in a results file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from .dataset import Data


@dataclass(frozen=True)
class Reported:
    """Warnings {"code", "message"} as they are stored."""

    codes: Annotated[tuple[str, ...], Data("w", text="a word for each warning of the analysis")]
    messages: Annotated[tuple[str, ...], Data("w", text="the warning for people")]

    @classmethod
    def of(cls, warnings: Sequence[Mapping[str, str]]) -> "Reported":
        """Return the columns of warnings."""
        return cls(*(tuple(w[key] for w in warnings) for key in ("code", "message")))

    def value(self) -> tuple[dict[str, str], ...]:
        """Return the warnings."""
        rows = zip(self.codes, self.messages, strict=True)
        return tuple({"code": code, "message": message} for code, message in rows)
