"""Files as VTK, and with it ParaView, reads them.

PyVista takes a second of CPU time to load, and as much again when pytest looks at it in the names
of a test file: it is loaded by the tests that need it.
"""

from pathlib import Path
from typing import Any

import numpy as np


def grid_of(file: Path) -> Any:
    """Read the grid of a file."""
    import pyvista

    return pyvista.read(file)


class Player:
    """The file of a motion as ParaView drives its reader."""

    def __init__(self, file: Path) -> None:
        import pyvista
        from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

        self._wrap = pyvista.wrap
        self.reader = pyvista.get_reader(file).reader
        self.reader.UpdateInformation()
        steps = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        self.times = np.array(self.reader.GetOutputInformation(0).Get(steps))  # [s]

    def at(self, step: int) -> Any:
        """Read the grid at a time."""
        self.reader.UpdateTimeStep(self.times[step])
        return self._wrap(self.reader.GetOutputDataObject(0)).copy()
