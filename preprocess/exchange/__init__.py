"""Bodies from and to other codes; needs NumPy, SciPy and h5py only (docs/exchange.md)."""

from .reduce import from_matrices

__all__ = ["from_matrices"]
