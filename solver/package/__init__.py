"""The modal package: one HDF5 file per flexible body (docs/format.md).

Each name below is imported when it is asked for: section and shell files need a part of this
folder only. __init__.pyi declares their types.
"""

from ..errors import PackageError
from ..math.catalogue import lazy_names

# Public name -> module of this folder.
_PUBLIC = {
    "Interface": "body.package_schema",
    "Invariants": "body.package_schema",
    "ModalPackage": "body.package_schema",
    "Remark": "common.findings",
    "SectionData": "body.package_schema",
    "from_stations": "body.invariants",
    "read_package": "body.package_file",
    "validate": "validation",
    "write_package": "body.package_file",
}
__all__ = ["PackageError", *_PUBLIC]

__getattr__, __dir__ = lazy_names(_PUBLIC, globals())
