"""From a resolved run and its packages to a model, its names and its start."""

from .build import BuiltMechanism, build
from .joints import BuiltJoint

__all__ = ["BuiltJoint", "BuiltMechanism", "build"]
