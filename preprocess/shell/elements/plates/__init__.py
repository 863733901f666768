"""Bending of a flat triangle: one file for each element; see contract.py."""

from .....solver.math.catalogue import catalogue, listed
from .....solver.package.shell import elements
from .contract import Plate, PlateStrains, shear_ratio

PLATES = listed(catalogue(__name__, __path__, Plate), elements.PLATES, "plates")
