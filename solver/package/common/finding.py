"""Findings of the checks of a file."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ...errors import PackageError

Reporter = Callable[[str, str], None]  # arguments: dataset and message


@dataclass(frozen=True)
class Finding:
    """One finding about a package."""

    level: str  # error (unusable), warning (suspicious) or note
    dataset: str
    message: str


def raise_first(path: Path, findings: list[Finding]) -> None:
    """Raise the first error among findings as PackageError, with the number of further errors."""
    errors = [f for f in findings if f.level == "error"]
    if errors:
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        raise PackageError(f"{path}: {errors[0].dataset}: {errors[0].message}{more}")
