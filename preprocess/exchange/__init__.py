"""Bodies from and to other codes; needs NumPy, SciPy and h5py only (docs/exchange.md)."""

from typing import Any

__all__ = ["from_matrices"]


def __getattr__(name: str) -> Any:
    """The reduction when it is asked for: an export needs neither it nor SciPy, half a second."""
    if name in __all__:
        from . import reduce

        return getattr(reduce, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
