"""Reduced basis of a body: eigenmodes under a reference condition, and static modes of loads."""

from .eigenmodes import Eigenmodes, ModeRequest
from .kinds import KINDS, Participation, clusters, separating_rotation, shares_of
from .reduced import Modes, completed, reduced_modes
from .reference import Algebra, Condition, EigenSolver, HeldDofs, MeanAxis, ModeError
from .static import StaticLoad, accelerations, inertia_loads

__all__ = [
    "KINDS",
    "Algebra",
    "Condition",
    "EigenSolver",
    "Eigenmodes",
    "HeldDofs",
    "MeanAxis",
    "ModeError",
    "ModeRequest",
    "Modes",
    "Participation",
    "StaticLoad",
    "accelerations",
    "clusters",
    "completed",
    "inertia_loads",
    "reduced_modes",
    "separating_rotation",
    "shares_of",
]
