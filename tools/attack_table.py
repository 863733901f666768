"""Write the table of an attack into docs/security.md: python tools/attack_table.py COUNTS.jsonl."""

import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from harness.hostile_profile import (  # type: ignore[import-not-found]
    BAD,
    GOOD,
    MISSED,
    recorded,
)

PAGE = Path(__file__).resolve().parents[1] / "docs/security.md"
BEGIN, END = "<!-- attack: begin -->\n", "<!-- attack: end -->\n"


def table(counts: Counter[tuple[str, str]]) -> str:
    """Return the table: a line for each kind of try, a column for each end.

    Faults that came too late are in the last column only.
    """
    bad = [end for end in BAD if end != "other"]
    ends = (*GOOD, *bad)
    lines = [
        f"| tries | number | {' | '.join(ends)} | {MISSED} |",
        f"|---|{'---:|' * (2 + len(ends))}",
    ]
    kinds = sorted({kind for kind, _ in counts})
    for name, own in [*((kind, [kind]) for kind in kinds), ("all", kinds)]:
        found = [sum(counts[kind, end] for kind in own) for end in (*ends, MISSED)]
        number = sum(counts[kind, end] for kind in own for end in (*GOOD, *BAD))
        lines.append(f"| {name} | {number} | {' | '.join(map(str, found))} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Read counts (tests/harness/hostile_profile.py) and replace the table of the page."""
    _, counts = recorded(Path(sys.argv[1]))
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    PAGE.write_text(before + BEGIN + table(counts) + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
