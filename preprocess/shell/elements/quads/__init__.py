"""Bending of a quadrilateral: one file for each element; see contract.py. And its membrane."""

from .....solver.math.catalogue import catalogue, listed
from .....solver.package.shell import elements
from .contract import QuadPlate

QUADS = listed(
    [(plate.name, plate) for plate in catalogue(__name__, __path__, QuadPlate)],
    elements.QUADS,
    "quads",
)

__all__ = ["QUADS", "QuadPlate"]
