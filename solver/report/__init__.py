"""The report of a case: figures, report.html and a table on the screen.

Each name below is imported when it is asked for: figures of other commands use style.py only.
__init__.pyi tells their types.
"""

from importlib import import_module

# Public name -> module of this folder.
_PUBLIC = {
    "make_report": "build",
    "summary_table": "table",
    "write_glb": "glb",
    "write_vtk": "vtk",
}
__all__ = [*_PUBLIC]


def __getattr__(name: str) -> object:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(f"{__name__}.{_PUBLIC[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted([*globals(), *_PUBLIC])
