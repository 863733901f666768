from .build import make_report as make_report
from .glb import write_glb as write_glb
from .table import summary_table as summary_table
from .vtk import write_vtk as write_vtk
