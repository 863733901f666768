"""Cross-section analysis: 6x6 stiffness and mass of a beam of any material."""

from .analysis import SectionResult, analyse
from .mesh import SectionError

__all__ = ["SectionError", "SectionResult", "analyse"]
