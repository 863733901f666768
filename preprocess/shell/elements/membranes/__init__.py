"""Membrane of a flat triangle: one file for each element; see contract.py."""

from .....solver.math.catalogue import catalogue, listed
from .....solver.package.shell import elements
from .contract import Membrane, MembraneStrains

MEMBRANES = listed(catalogue(__name__, __path__, Membrane), elements.MEMBRANES, "membranes")
