"""case.json: what the report needs to know of a case."""

import re
from typing import Any

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")  # of a run, or a figure: part of a file name


def case_table(found: Any) -> dict[str, Any]:
    """Return the content of case.json. Raises ValueError if `check` cannot have written it."""
    if not isinstance(found, dict):
        raise ValueError(f"expected a table, found {type(found).__name__}")
    for key in ("runs", "figures"):
        named = found.get(key, {})
        if not isinstance(named, dict) or (key == "runs" and not named):
            raise ValueError(f"key {key}: expected a table of names")
        for name in named:
            if not _NAME.fullmatch(name):
                raise ValueError(f"key {key}: expected letters and digits in {name!r}")
    for name, figure in found.get("figures", {}).items():
        if not (isinstance(figure, dict) and _is_figure(figure)):
            raise ValueError(f"key figures.{name}: expected title, signal and a list of runs")
    return found


def _is_figure(figure: dict[str, Any]) -> bool:
    runs = figure.get("runs")
    words = [figure.get("title"), figure.get("signal"), *(runs if isinstance(runs, list) else [0])]
    return all(isinstance(word, str) for word in words)
