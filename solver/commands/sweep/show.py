"""What became of the members of a sweep, on the screen."""

import os
from collections.abc import Sequence
from pathlib import Path

from ...results.codes import CODES
from .file import SweepResult
from .member import FAILED, FINISHED, PENDING, STOPPED

TOLD = 10  # members that did not finish


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
    others = [
        (k, row) for k, row in enumerate(result.rows) if row.status not in (FINISHED, PENDING)
    ]
    for k, row in others[:TOLD]:
        values = zip(result.parameter_names, result.values[k], strict=True)
        where = ", ".join(f"{name} = {value:g}" for name, value in values)
        code = f" [{row.code}]" if row.code else ""
        print(f"  {row.status}{code} {where}: {row.message}")
    if len(others) > TOLD:
        print(f"  ... and {len(others) - TOLD} more")
    doubts: dict[str, int] = {}
    for row in result.rows:
        for code in row.warnings:
            doubts[code] = doubts.get(code, 0) + 1
    for code, count in sorted(doubts.items()):
        level = CODES[code].level if code in CODES else "warning"
        print(f"  {level} [{code}] in {count} of {total} members")
