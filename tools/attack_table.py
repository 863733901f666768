"""Write the table of an attack into docs/security.md: python tools/attack_table.py COUNTS.jsonl."""

import json
import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from hostile_profile import BAD, GOOD  # type: ignore[import-not-found]

PAGE = Path(__file__).resolve().parents[1] / "docs/security.md"
BEGIN, END = "<!-- attack: begin -->\n", "<!-- attack: end -->\n"


def table(counts: Counter[tuple[str, str]]) -> str:
    """Return the table: a line for each kind of try, a column for each end."""
    bad = [end for end in BAD if end != "other"]
    lines = [
        f"| tries | number | {' | '.join((*GOOD, *bad))} |",
        f"|---|{'---:|' * (1 + len(GOOD) + len(bad))}",
    ]
    kinds = sorted({kind for kind, _ in counts})
    for kind in (*kinds, "all"):
        own = [counts[kind, end] for end in (*GOOD, *bad)]
        if kind == "all":
            own = [sum(counts[k, end] for k in kinds) for end in (*GOOD, *bad)]
        total = sum(n for (k, _), n in counts.items() if kind in ("all", k))
        lines.append(f"| {kind} | {total} | {' | '.join(map(str, own))} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Read counts (tests/hostile_profile.py) and replace the table of the page."""
    lines = Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()
    found = table(Counter((kind, end) for kind, end in map(json.loads, lines)))
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    PAGE.write_text(before + BEGIN + found + END + after, encoding="utf-8")
    print(found, end="")


if __name__ == "__main__":
    main()
