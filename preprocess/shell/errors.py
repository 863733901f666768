"""Error classes of the shell analysis."""

from ...solver.math.arrays import IntArray


class ShellError(Exception):
    """The description of a shell is wrong, or the shell cannot be analysed."""


class CellError(ShellError):
    """Cells that cannot be elements.

    Attributes
    ----------
    kind : "triangles" or "quadrilaterals"
    fault : what is wrong with each
    rows : (k,) the wrong ones
    """

    def __init__(self, message: str, kind: str, fault: str, rows: IntArray) -> None:
        super().__init__(message)
        self.kind, self.fault, self.rows = kind, fault, rows
