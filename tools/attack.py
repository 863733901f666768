"""The attack of tests/hostile: python tools/attack.py [--write | WORDS OF PYTEST].

Tells every half minute how far it is. Interrupted, the same command goes on after the last test
that was over, as long as no source has changed. The last thing that it prints is its table, which
`--write` puts into docs/attack.md.
"""

import hashlib
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from harness.hostile_profile import (  # type: ignore[import-not-found]  # noqa: E402
    BAD,
    GOOD,
    MISSED,
    recorded,
)

FOLDER = ROOT / "build/attack"
COUNTS, SOURCES, OUTPUT = (FOLDER / name for name in ("counts.jsonl", "sources", "pytest.log"))
TOLD_S = 30.0
PAGE = ROOT / "docs/attack.md"
BEGIN, END = "<!-- attack: begin -->\n", "<!-- attack: end -->\n"


def sources() -> str:
    """Return a digest of all that the tries depend on."""
    digest = hashlib.sha256()
    for folder in ("solver", "preprocess", "meshes", "cases", "tests", "plymotion/api"):
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix in (".py", ".toml", ".geo", ".vtkhdf"):
                digest.update(f"{file.relative_to(ROOT)}\0".encode() + file.read_bytes())
    return digest.hexdigest()


def table(counts: Counter[tuple[str, str]]) -> str:
    """Return the table: a line for each group of tries, a column for each end.

    A try is recorded as "command: fault, detail"; a group has all commands, signals and details of
    a fault. Faults that came too late are in the last column only.
    """
    grouped: Counter[tuple[str, str]] = Counter()
    for (kind, end), number in counts.items():
        fault = kind.split(": ", 1)[-1].split(",")[0]
        grouped[re.sub("SIG[A-Z]+", "a signal", fault), end] += number
    counts = grouped
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


def write_page() -> None:
    """Replace the table of docs/attack.md by that of the last attack."""
    _, counts = recorded(COUNTS)
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    PAGE.write_text(before + BEGIN + table(counts) + END + after, encoding="utf-8")


def main() -> int:
    """Run the attack, or what is missing of it; return the exit code of pytest."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    now = sources()
    if not SOURCES.is_file() or SOURCES.read_text() != now:
        COUNTS.unlink(missing_ok=True)
        SOURCES.write_text(now)
    words = ["tests/hostile", "-n", "2", "--dist", "worksteal", "-q", *sys.argv[1:]]
    begin = time.monotonic()
    with OUTPUT.open("w", encoding="utf-8") as output:
        # A group of its own: all of it gets a signal that came to this process alone.
        process = subprocess.Popen(
            [sys.executable, "-m", "pytest", *words],
            cwd=ROOT,
            env=os.environ | {"PLYMOTION_ATTACK": str(COUNTS)},
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        try:
            while True:
                try:
                    code = process.wait(TOLD_S)
                    break
                except subprocess.TimeoutExpired:
                    _tell(time.monotonic() - begin)
        except KeyboardInterrupt:
            os.killpg(process.pid, signal.SIGINT)
            process.wait()
            print(f"interrupted: {_far()}; the same command goes on from there")
            return 130
    _tell(time.monotonic() - begin)
    over, counts = recorded(COUNTS)
    print(table(counts), end="")
    bad = sum(n for (_, end), n in counts.items() if end in BAD)
    if code not in (0, 5) or bad:  # 5: nothing was left to do
        print(OUTPUT.read_text(encoding="utf-8")[-20_000:])
        failed = [test for test, end in over.items() if end == "failed"]
        print("\n".join([f"{bad} tries ended badly; tests that failed:", *failed]))
        return 1
    return 0


def _far() -> str:
    over, counts = recorded(COUNTS)
    return f"{counts.total()} tries, {len(over)} tests"


def _tell(seconds: float) -> None:
    print(f"attack: {_far()} after {seconds / 60.0:.1f} min", file=sys.stderr, flush=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        write_page()
    else:
        sys.exit(main())
