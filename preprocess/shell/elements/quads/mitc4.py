"""MITC4: bilinear rotations, shear strain tied on the sides (Bathe and Dvorkin 1985)."""

from ..plates.mitc3 import mitc3
from .contract import QuadPlate

QUAD = QuadPlate("mitc4", mitc3)
