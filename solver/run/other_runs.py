"""Other runs that the combined signals of a run read: they are integrated with it."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..inputs.case.combining import needed
from ..math.arrays import Array
from ..signals import Histories, recorded
from .integration import complete
from .outcome import RunSpec
from .preparation import prepare

if TYPE_CHECKING:
    from ..inputs.case.signals import Signal as SignalTable


def histories_of(
    signals: Mapping[str, "SignalTable"],
    runs: Mapping[str, RunSpec],
    *,
    allow_python: bool = False,
) -> Histories:
    """Return times and signals of the other runs that signals read.

    A run that ends early has fewer times.

    Parameters
    ----------
    signals : of a case; those of them that are combined
    runs : the other runs by name

    Raises
    ------
    InputError
        As `prepare`, of another run.
    """
    found: dict[str, tuple[Array, dict[str, Array]]] = {}
    for run, names in needed(signals).items():
        other = runs[run]
        prepared = prepare(other.mechanism, other.packages, names, allow_python=allow_python)
        finished = complete(prepared)
        recordings = recorded(prepared.measured, finished.model, finished.blocks)
        blocks = [(recording, dict(rows)) for recording, rows in recordings]
        values = {name: np.concatenate([v[name] for _, v in blocks]) for name in names}
        found[run] = np.concatenate([r.t for r, _ in blocks]), values
    return found
