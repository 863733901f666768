"""Case files: from TOML to a checked mechanism, body specifications and runs.

What reads and checks a case is imported when it is asked for: a run needs the mechanism only.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .reading.load import Case, load_case

__all__ = ["Case", "load_case"]


def __getattr__(name: str) -> Any:
    if name in ("Case", "load_case"):
        from .reading import load

        return getattr(load, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
