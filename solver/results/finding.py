"""An error, warning or note about a run."""

from dataclasses import dataclass
from math import isnan, nan
from typing import Any, Literal

# error: the results cannot be used, or end early; warning: they may be wrong; note: worth knowing.
Level = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """What was found, where and when, and how far it is beyond its limit.

    `value` and `limit` are in the unit of the code (results/codes.py, docs/warnings.md).
    """

    code: str
    text: str  # what happened, what was expected, what helps
    body: str = ""  # name of the body or joint, empty if it concerns the whole run
    t: float | None = None  # [s]
    value: float | None = None
    limit: float | None = None
    level: Level = "warning"

    def entry(self) -> dict[str, Any]:
        """Return the entry of summary.json; keys without a value are left out."""
        more = {"body": self.body or None, "t": self.t, "value": self.value, "limit": self.limit}
        known = {key: value for key, value in more.items() if value is not None}
        return {"code": self.code, "message": self.text, "level": self.level, **known}


@dataclass(frozen=True)
class Code:
    """A kind of finding; docs/warnings.md has meaning, threshold and remedy."""

    name: str
    level: Level
    limit: float = nan

    def finding(
        self, text: str, *, body: str = "", t: float | None = None, value: float | None = None
    ) -> Finding:
        """Return a finding of this code."""
        limit = None if isnan(self.limit) else self.limit
        return Finding(self.name, text, body, t, value, limit, self.level)
