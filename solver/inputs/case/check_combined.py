"""Checks of combined signals: names of signals and runs, and that none depends on itself."""

from collections.abc import Iterator, Mapping
from typing import Any

from ...errors import nearest
from .combining import KINDS, elsewhere, parts
from .schema import Mechanism


def check_combined(mechanism: Mechanism) -> Iterator[str]:
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


def check_elsewhere(mechanism: Mechanism, runs: Mapping[str, Mechanism]) -> Iterator[str]:
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
