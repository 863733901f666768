"""Compile what sections of the library need: `python -m plymotion.preprocess.section.ahead`.

`make fenicsx` calls it, so that a first analysis compiles nothing. Meshes of one cell have the same
expressions as others: those of straight and curved quadrilaterals, which the shapes of the library
have, for a field of the default degree 2 and for its estimate, which also takes it at the points of
degree 3.
"""

import numpy as np

from ..fenicsx import NODES
from .cells import FULL, KINDS, CellMesh
from .space import SectionSpace
from .twist import TwistedStrains


def compile_ahead(cell: str = "quadrilateral") -> None:
    """Evaluate all expressions of one straight and of one curved cell."""
    kind = np.array([KINDS.index(cell)])
    nodes = np.arange(9)[None, :]
    nodes[0, FULL[kind[0]] :] = -1
    for bulge in (0.0, 0.1):
        points = NODES[cell] / 2.0
        points[len(points) // 2, 1] -= bulge  # the middle of the first edge
        mesh = CellMesh(points, nodes, kind, np.zeros(1, dtype=np.int64), ("",))
        coarse, rich = (SectionSpace(mesh, degree) for degree in (2, 3))
        for space in (coarse, rich, SectionSpace(mesh, 2, rich.quadrature_degree)):
            TwistedStrains(space, np.zeros(3)).S.sum()


if __name__ == "__main__":
    compile_ahead()
