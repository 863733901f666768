"""Elements of report.html: figures, tables, names of runs."""

import base64
from html import escape
from pathlib import Path

from .story import Story


def figure(path: Path, caption: str, kind: str = "") -> str:
    """Return a figure that is embedded in the page."""
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return (
        f"<figure class='{kind}'><img alt='{escape(caption, quote=True)}' "
        f"src='data:image/png;base64,{data}'></figure>"
    )


def table(head: str, rows: list[list[str]]) -> str:
    """Return a table; `head` has the cells of its first row."""
    body = "".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    whole = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f"<div class='scroll'>{whole}</div>"


def name_of(story: Story) -> str:
    """Return title and name of a run."""
    code = f"<code>{escape(story.name)}</code>"
    return f"{escape(story.title)}<br>{code}" if story.title != story.name else code
