"""Build model, names and start of a mechanism from a resolved run and its packages."""

from .build import BuiltMechanism, build
from .case_tables import BuiltJoint

__all__ = ["BuiltJoint", "BuiltMechanism", "build"]
