"""Cross-section analysis: 6x6 stiffness and mass of a beam of any material, and its stresses."""

from typing import TYPE_CHECKING, Any

from .errors import SectionError

if TYPE_CHECKING:
    from .analysis import analyse

__all__ = ["SectionError", "analyse"]


def __getattr__(name: str) -> Any:
    if name != "analyse":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .analysis import analyse  # here: a file that is up to date needs no analysis

    globals()[name] = analyse
    return analyse
