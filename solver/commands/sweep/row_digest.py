"""The digest of a member's row in sweep.h5: a restart believes no other row."""

import hashlib
from collections.abc import Iterable

import numpy as np

from ...results.summary import MEASURES
from .member import CHECKS, COST, Row

TEXTS = ("key", "status", "message", "code")


def row_sha256(row: Row, signals: Iterable[str], histories: Iterable[str], n_t: int) -> str:
    """Return the digest of all that the file keeps of a row.

    Parameters
    ----------
    signals, histories : names in the file; `n_t` is the number of output times of histories
    """
    texts = [getattr(row, name) for name in TEXTS] + list(row.warnings)
    numbers = [row.t_end]
    for name in sorted(signals):
        numbers += [_number(row.signals.get(name, {}).get(measure)) for measure in MEASURES]
    numbers += [row.checks.get(name, np.nan) for name in CHECKS]
    numbers += [row.cost.get(name, np.nan) for name in COST]
    digest = hashlib.sha256("\0".join(texts).encode())
    digest.update(_plain(numbers))
    nothing = np.full(n_t, np.nan)
    for name in sorted(histories):
        digest.update(_plain(row.histories.get(name, nothing)))
    return digest.hexdigest()


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def _plain(values: object) -> bytes:
    """Return numbers as bytes, every NaN the same."""
    array = np.array(values, dtype="<f8")
    array[np.isnan(array)] = np.nan
    return array.tobytes()
