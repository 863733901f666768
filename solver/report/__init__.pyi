from .animation import write_glb as write_glb
from .animation import write_vtk as write_vtk
from .report_page import make_report as make_report
from .table import summary_table as summary_table
