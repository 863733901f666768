"""Docstrings as autodoc reads them: an example after a section gets a heading of its own."""

from typing import Any

from sphinx.application import Sphinx


def _headed(app: Sphinx, what: str, name: str, found: Any, options: Any, lines: list[str]) -> None:
    """Put a heading before the first example, which else belongs to the section above."""
    if "Examples" in lines:
        return
    for number, line in enumerate(lines):
        if line.startswith(">>>"):
            lines[number:number] = ["Examples", "--------"]
            return


def setup(app: Sphinx) -> dict[str, Any]:
    """Before napoleon, which turns sections into markup."""
    app.connect("autodoc-process-docstring", _headed, priority=1)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
