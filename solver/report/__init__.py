"""The report of a case: figures, report.html and a table on the screen."""

from .build import make_report
from .table import summary_table

__all__ = ["make_report", "summary_table"]
