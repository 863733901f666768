"""The modal package: one HDF5 file per flexible body (docs/format.md).

Each name below is imported when it is asked for: section and shell files need a part of this
folder only. __init__.pyi tells their types.
"""

from importlib import import_module

from ..errors import PackageError

# Public name -> module of this folder.
_PUBLIC = {
    "Interface": "body.schema",
    "Invariants": "body.schema",
    "ModalPackage": "body.schema",
    "Remark": "common.remark",
    "SectionData": "body.schema",
    "from_stations": "body.invariants",
    "read_package": "body.io",
    "validate": "validation",
    "write_package": "body.io",
}
__all__ = ["PackageError", *_PUBLIC]


def __getattr__(name: str) -> object:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(f"{__name__}.{_PUBLIC[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted([*globals(), *_PUBLIC])
