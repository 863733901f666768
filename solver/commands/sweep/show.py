"""What became of the members of a sweep, on the screen."""

import os
import re
from collections.abc import Sequence
from pathlib import Path

from ...results.codes import CODES
from .file import SweepResult
from .member import FAILED, FINISHED, PENDING, STOPPED, Row

TOLD = 10  # kinds of messages of members that did not finish
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


def tell(
    result: SweepResult,
    kept: int,
    seconds: float,
    file: Path,
    table: str,
    planned: Sequence[str] = (),
) -> None:
    """Print what became of the members.

    Parameters
    ----------
    kept : how many were not computed; the others took `seconds`
    table : more words about files
    planned : lines on the plan of [fidelity]
    """
    total = len(result.rows)
    counts = [
        f"{result.count(s)} {s}" for s in (FINISHED, STOPPED, FAILED, PENDING) if result.count(s)
    ]
    shown = os.path.relpath(file)
    print(f"{result.name}: {total} members, {', '.join(counts)}; {shown}{table}")
    computed = total - kept - result.count(PENDING)
    print(f"  {computed} computed in {seconds:.1f} s, {kept} kept from before")
    for line in planned:
        print(f"  {line}")
    groups = _alike(result.rows)
    for members in groups[:TOLD]:
        row = result.rows[members[0]]
        values = zip(result.parameter_names, result.values[members[0]], strict=True)
        where = ", ".join(f"{name} = {value:g}" for name, value in values)
        code = f" [{row.code}]" if row.code else ""
        many = f"{len(members)} members, first " if len(members) > 1 else ""
        print(f"  {row.status}{code} {many}{where}: {row.message}")
    if len(groups) > TOLD:
        print(f"  ... and {sum(map(len, groups[TOLD:]))} more members")
    doubts: dict[str, int] = {}
    for row in result.rows:
        for code in row.warnings:
            doubts[code] = doubts.get(code, 0) + 1
    for code, count in sorted(doubts.items()):
        level = CODES[code].level if code in CODES else "warning"
        print(f"  {level} [{code}] in {count} of {total} members")


def _alike(rows: Sequence[Row]) -> list[list[int]]:
    """Return the members that did not finish, in groups whose messages differ in numbers only."""
    found: dict[tuple[str, str, str], list[int]] = {}
    for k, row in enumerate(rows):
        if row.status not in (FINISHED, PENDING):
            words = NUMBER.sub("#", row.message)
            found.setdefault((row.status, row.code, words), []).append(k)
    return list(found.values())
