"""Tables of the file formats in the manual, from the fields of their dataclasses (`make docs`).

python tools/format_pages.py docs
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from plymotion.solver.package.body.package_file import MODAL_PACKAGE
from plymotion.solver.package.common.dataset import layout, named
from plymotion.solver.package.common.object_file import ObjectFormat
from plymotion.solver.package.section.section_file import SECTION_FILE
from plymotion.solver.package.shell.shell_file import SHELL_FILE

PAGES: dict[str, ObjectFormat[Any]] = {
    "format.md": MODAL_PACKAGE,
    "section-file.md": SECTION_FILE,
    "shells.md": SHELL_FILE,
}


def rows(kind: Any, at: str = "") -> Iterator[str]:
    """Yield the rows of the table of a dataclass."""
    for spec in layout(kind):
        if spec.type != "attribute":
            may = " (optional)" if spec.optional or spec.within else ""
            words = (spec.stored, spec.unit, spec.frame, f"{spec.text}{may}")
            yield f"| {' | '.join((f'`{at}{spec.path}`', spec.words, *words))} |"
    for parent, (member, _) in named(kind).items():
        yield from rows(member, f"{at}{parent}/<{parent.removesuffix('s')}>/")


def with_table(text: str, group: str, kind: Any) -> str:
    """Return the text of a page with its table of datasets written anew.

    A page has paths below the group of the format, or whole ones.
    """
    head = rf"(\| dataset (below|in) `/{group}` \|.*\n\|[-|]+\n)(?:\| `.*\n)*"
    found = re.search(head, text)
    if found is None:
        return text
    table = "".join(f"{row}\n" for row in rows(kind, "" if found[2] == "below" else f"/{group}/"))
    return text[: found.start()] + found[1] + table + text[found.end() :]


if __name__ == "__main__":
    for name, known in PAGES.items():
        page = Path(sys.argv[1]) / name
        text = page.read_text(encoding="utf-8")
        page.write_text(with_table(text, known.group, known.kind), encoding="utf-8")
