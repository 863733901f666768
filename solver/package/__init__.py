"""The modal package: one HDF5 file per flexible body (docs/format.md)."""

from ..errors import PackageError
from .body.invariants import from_stations
from .body.io import read_package, write_package
from .body.schema import Interface, Invariants, ModalPackage, SectionData
from .common.remark import Remark
from .validate import validate

__all__ = [
    "Interface",
    "Invariants",
    "ModalPackage",
    "PackageError",
    "Remark",
    "SectionData",
    "from_stations",
    "read_package",
    "validate",
    "write_package",
]
