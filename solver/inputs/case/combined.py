"""Signals made of other signals: a difference, also to another run, and a norm."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import Field, model_validator

from ...errors import nearest
from ..common.table import Name, Table
from .combining import KINDS, elsewhere, parts

if TYPE_CHECKING:
    from .schema import Mechanism

RUN = (
    "name of another run, whose values at the same times are subtracted; in a sweep with the same "
    "changes. NaN after that run has ended"
)


class Measured(Table):
    """Keys of every signal."""

    divide_by: float | None = Field(
        default=None, gt=0, description="makes the signal dimensionless (in its unit)"
    )
    description: str = Field(default="", description="words for figures and tables")


class DifferenceSignal(Measured):
    """`[signals.NAME]` with kind = "difference": a signal minus another, or minus another run."""

    kind: Literal["difference"]
    of: Name = Field(description="name of a signal")
    minus: Name | None = Field(
        default=None, description="name of the signal that is subtracted; absent: `of`"
    )
    run: Name | None = Field(default=None, description=RUN)

    @model_validator(mode="after")
    def _of_two(self) -> Self:
        if self.minus is None and self.run is None:
            raise ValueError("expected `minus`, `run` or both")
        return self


class NormSignal(Measured):
    """`[signals.NAME]` with kind = "norm": square root of the sum of squares of signals."""

    kind: Literal["norm"]
    of: list[Name] = Field(min_length=1, description="names of signals of one unit")
    run: Name | None = Field(default=None, description=f"of their differences to it: {RUN}")


def check_combined(mechanism: "Mechanism") -> Iterator[str]:
    """Yield what is wrong with the combined signals of a run, apart from the other run."""
    signals: Mapping[str, Any] = mechanism.signals
    for name, signal in signals.items():
        if signal.kind not in KINDS:
            continue
        for part in parts(signal):
            if part not in signals:
                hint = nearest(part, signals)
                yield f'signals.{name}.of = "{part}": no such signal{hint}'
        if _depends_on(name, name, signals, frozenset()):
            yield f"signals.{name}: depends on itself; expected other signals"
        if mechanism.fidelity is not None and signal.run is not None:
            yield f"signals.{name}.run: expected none with [fidelity]"


def _depends_on(name: str, wanted: str, signals: Mapping[str, Any], seen: frozenset[str]) -> bool:
    if name in seen or name not in signals:
        return False
    inner = parts(signals[name])
    return wanted in inner or any(
        _depends_on(part, wanted, signals, seen | {name}) for part in inner
    )


def check_elsewhere(mechanism: "Mechanism", runs: Mapping[str, "Mechanism"]) -> Iterator[str]:
    """Yield what is wrong with the runs that the combined signals of a run read."""
    signals: Mapping[str, Any] = mechanism.signals
    for name, signal in signals.items():
        if not elsewhere(signal):
            continue
        if signal.run not in runs:
            yield f'signals.{name}.run = "{signal.run}": no such run{nearest(signal.run, runs)}'
            continue
        there: Mapping[str, Any] = runs[signal.run].signals
        for part in elsewhere(signal):
            if part not in there:
                yield f'signals.{name}: run {signal.run} has no signal "{part}"'
            elif elsewhere(there[part]):
                yield f'signals.{name}: "{part}" reads another run itself; expected a plain signal'
