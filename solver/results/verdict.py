"""What the results of a run are worth, by its own findings: one judgement for screen and report."""

from typing import Any, Literal

Verdict = Literal["good", "doubt", "bad"]


def verdict(summary: dict[str, Any]) -> Verdict:
    """Return what a run is worth.

    "bad": it ended early, or a finding of level error calls its results invalid; "doubt": it has
    warnings; "good": neither.
    """
    levels = {found.get("level", "warning") for found in summary.get("warnings", [])}
    if not summary.get("completed", False) or "error" in levels:
        return "bad"
    return "doubt" if "warning" in levels else "good"


def invalid_words(summary: dict[str, Any]) -> str:
    """Return from when on a completed run is invalid, and why; empty if it is not."""
    errors = [f for f in summary.get("warnings", []) if f.get("level") == "error"]
    if not errors or not summary.get("completed", False):
        return ""
    first = min(errors, key=lambda found: found.get("t") or 0.0)
    return f"invalid from t = {first.get('t') or 0.0:.4g} s ({first['code']})"
