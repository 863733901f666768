"""DKMQ: the discrete Kirchhoff-Mindlin quadrilateral (Katili 1993), as the triangle.

The ratio phi_k of a side has a part of the width (side_widths.py), which with the internal
rotations (internal.py) lets a strip of one cell twist.
"""

from ..plates.dkmt import dkmt
from .contract import QuadPlate

QUAD = QuadPlate("dkmq", dkmt, internal=True)
