"""Tables that a benchmark writes into a document, between two lines of its own."""

from collections.abc import Sequence
from pathlib import Path


def replace_between(path: Path, name: str, lines: Sequence[str]) -> None:
    """Put lines between `<!-- name: begin -->` and `<!-- name: end -->` of a file."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    text = path.read_text(encoding="utf-8")
    if text.count(begin) != 1 or text.count(end) != 1:
        raise SystemExit(f"{path}: expected one line {begin} and one {end}")
    before, _, rest = text.partition(begin)
    after = rest.partition(end)[2]
    part = path.with_name(f"{path.name}.part")
    part.write_text(before + "\n\n".join([begin, "\n".join(lines), end]) + after, encoding="utf-8")
    part.replace(path)
