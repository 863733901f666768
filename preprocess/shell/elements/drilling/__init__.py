"""Stiffness against the rotation about the normal: one file for each form; see contract.py."""

from .....solver.math.catalogue import catalogue, listed
from .....solver.package.shell import elements
from .contract import Drilling

DRILLINGS = listed(
    catalogue(__name__, __path__, Drilling), elements.DRILLINGS, "drilling stiffnesses"
)
