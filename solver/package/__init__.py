"""The modal package: one HDF5 file per flexible body (docs/format.md).

Each name below is imported when it is asked for: section and shell files need a part of this
folder only. __init__.pyi declares their types.
"""

from ..errors import PackageError
from ..math.catalogue import lazy_names

# Module of this folder -> public names.
_PUBLIC = {
    "body.package_schema": ("Interface", "Invariants", "ModalPackage", "SectionData"),
    "body.invariants": ("from_stations",),
    "body.package_file": ("read_package", "write_package"),
    "common.findings": ("Remark",),
    "validation": ("validate",),
}

__getattr__, __dir__ = lazy_names(_PUBLIC, globals())
