"""The modal package: one HDF5 file per flexible body (docs/format.md)."""

from ..errors import PackageError
from .finding import Finding
from .invariants import from_stations
from .io import read_package, write_package
from .schema import Interface, Invariants, ModalPackage, SectionData
from .validate import validate

__all__ = [
    "Finding",
    "Interface",
    "Invariants",
    "ModalPackage",
    "PackageError",
    "SectionData",
    "from_stations",
    "read_package",
    "validate",
    "write_package",
]
