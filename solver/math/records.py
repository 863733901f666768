"""Records: classes of named values that do not change."""

from dataclasses import dataclass, field
from typing import Any, dataclass_transform


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def record(kind: Any = None, /, **options: Any) -> Any:
    """Make a dataclass that only type checkers treat as frozen, without comparison and text.

    Python compiles each method that a dataclass gets when its module is imported. With those that
    refuse changes, compare and print, the classes of a run took 0.01 s at its start.
    """
    return dataclass(kind, eq=False, repr=False, match_args=False, **options)
