"""The report of a case: figures, report.html and a table on the screen."""
