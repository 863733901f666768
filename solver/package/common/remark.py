"""Result of a check of a file."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ...errors import PackageError

Reporter = Callable[[str, str], None]  # arguments: dataset and message


@dataclass(frozen=True)
class Remark:
    """One remark on a package."""

    level: str  # error (unusable), warning (suspicious) or note
    dataset: str
    message: str


def raise_first(path: Path, findings: list[Remark]) -> None:
    """Raise the first error among findings as PackageError, with the number of others."""
    errors = [f for f in findings if f.level == "error"]
    if errors:
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        raise PackageError(f"{path}: {errors[0].dataset}: {errors[0].message}{more}")
