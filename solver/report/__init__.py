"""The report of a case: figures, report.html and a table on the screen."""

from .build import make_report
from .case_table import case_table
from .glb import write_glb
from .table import summary_table
from .vtk import write_vtk

__all__ = ["case_table", "make_report", "summary_table", "write_glb", "write_vtk"]
