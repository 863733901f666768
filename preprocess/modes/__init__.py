"""Reduced basis of a body: eigenmodes under a reference condition, and static modes of loads."""

from .eigenmodes import ModeRequest
from .kinds import KINDS, Participation
from .reduced import Modes, reduced_modes
from .reference import Algebra, Condition, EigenSolver, HeldDofs, MeanAxis, ModeError
from .static import StaticLoad, inertia_loads

__all__ = [
    "KINDS",
    "Algebra",
    "Condition",
    "EigenSolver",
    "HeldDofs",
    "MeanAxis",
    "ModeError",
    "ModeRequest",
    "Modes",
    "Participation",
    "StaticLoad",
    "inertia_loads",
    "reduced_modes",
]
