"""Case files: from TOML to a checked mechanism, body specifications and runs."""

from .load import Case, load_case
from .schema import CaseFile, Mechanism

__all__ = ["Case", "CaseFile", "Mechanism", "load_case"]
