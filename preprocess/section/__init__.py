"""Cross-section analysis: 6x6 stiffness and mass of a beam of any material, and its stresses."""

from typing import TYPE_CHECKING

from ...solver.math.catalogue import lazy_names
from .errors import SectionError

if TYPE_CHECKING:
    from .analysis.analysis import analyse

__all__ = ["SectionError", "analyse"]

# A file that is up to date needs no analysis.
__getattr__, __dir__ = lazy_names({"analyse": "analysis.analysis"}, globals())
