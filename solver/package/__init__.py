"""The modal package: one HDF5 file per flexible body (docs/format.md)."""

from ..errors import PackageError
from .body.invariants import from_stations
from .body.io import read_package, write_package
from .body.schema import Interface, Invariants, ModalPackage, SectionData
from .common.finding import Finding
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
