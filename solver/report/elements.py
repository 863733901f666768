"""Elements of report.html: sections, tables that can be sorted, names of runs."""

import re
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from .story import Story
from .table import number

_TAG = re.compile(r"<[^>]*>")
_NUMBER = re.compile(r"-?(\d[\d.]*(e[+-]?\d+)?|inf|nan)?")


class Cell(NamedTuple):
    """A cell of a table: HTML, and the number that it is sorted by."""

    html: str
    value: float | None = None


Row = Sequence[str | Cell]


def figures(value: float | None, digits: int = 3) -> Cell:
    """Return a number as a cell that is sorted by its full value."""
    return Cell(number(value, digits), value)


def section(name: str, title: str, *content: str) -> str:
    """Return a section with a heading and the anchor `name`."""
    inside = "\n".join(part for part in content if part)
    head = f"<h2 id='{name}-title'>{title}</h2>"
    return f"<section id='{name}' aria-labelledby='{name}-title'>{head}{inside}</section>"


def table(caption: str, head: Sequence[str], rows: Sequence[Row]) -> str:
    """Return a table that sorts by the column whose heading is pressed.

    `head` and the cells are HTML; a caption is for screen readers.
    """
    words = [any(_is_text(row[k]) for row in rows) for k in range(len(head))]
    top = "".join(
        f"<th scope='col'{_side(word)}>{text}</th>" for text, word in zip(head, words, strict=True)
    )
    body = "".join(f"<tr>{_cells(row, words)}</tr>" for row in rows)
    return (
        f"<div class='scroll' tabindex='0' role='region' aria-label='{escape(caption)}'>"
        f"<table class='sortable'><caption>{escape(caption)}</caption>"
        f"<thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _cells(row: Row, words: Sequence[bool]) -> str:
    found = []
    for k, (item, word) in enumerate(zip(row, words, strict=True)):
        html, value = item if isinstance(item, Cell) else (item, None)
        key = _side(word) + ("" if value is None else f" data-v='{value!r}'")
        found.append(f"<th scope='row'{key}>{html}</th>" if k == 0 else f"<td{key}>{html}</td>")
    return "".join(found)


def _is_text(item: str | Cell) -> bool:
    html = item.html if isinstance(item, Cell) else item
    return not _NUMBER.fullmatch(_TAG.sub("", html))


def _side(word: bool) -> str:
    """Columns of words begin at the left, those of numbers end at the right."""
    return " class='text'" if word else ""


def name_of(story: Story) -> str:
    """Return title and name of a run."""
    code = f"<code>{escape(story.name)}</code>"
    return f"{escape(story.title)}<br>{code}" if story.title != story.name else code
