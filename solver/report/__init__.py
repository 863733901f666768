"""The report of a case: figures, report.html and a table on the screen.

Each name below is imported when it is asked for: figures of other commands use style.py only.
__init__.pyi declares their types.
"""

from ..math.catalogue import lazy_names

# Public name -> module of this folder.
_PUBLIC = {
    "make_report": "report_page",
    "summary_table": "table",
    "write_glb": "animation",
    "write_vtk": "animation",
}
__all__ = [*_PUBLIC]

__getattr__, __dir__ = lazy_names(_PUBLIC, globals())
