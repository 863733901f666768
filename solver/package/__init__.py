"""The modal package: one HDF5 file per flexible body (docs/format.md)."""

from .invariants import from_stations
from .schema import Interface, Invariants, ModalPackage, PackageError, SectionData

__all__ = ["Interface", "Invariants", "ModalPackage", "PackageError", "SectionData", "from_stations"]
