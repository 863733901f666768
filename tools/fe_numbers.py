"""Compare the numbers that FE tests recorded on two versions of DOLFINx.

A file holds {"name": nested list of numbers}. Two arrays are equal when every
entry differs by at most 1e-9 of the largest entry of the array: single entries
may be zero except for round-off.
"""

import json
import math
import sys
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

TOLERANCE = 1e-9


def pairs(files: list[Path]) -> Iterator[tuple[Path, Path]]:
    """All pairs of files, each once."""
    return combinations(files, 2)


def flattened(value: Any) -> list[float]:
    """The numbers of a nested list, in order."""
    if isinstance(value, list):
        return [number for entry in value for number in flattened(entry)]
    return [float(value)]


def shape(value: Any) -> tuple[int, ...]:
    """Lengths of a nested list, outermost first."""
    if not isinstance(value, list):
        return ()
    return (len(value), *(shape(value[0]) if value else ()))


def differences(
    first: Path, second: Path, tolerance: float = TOLERANCE, common: bool = False
) -> list[str]:
    """One line for every name that is missing, has another shape or other numbers.

    `common` leaves out names that are in one file only, if there are others.
    """
    a, b = json.loads(first.read_text()), json.loads(second.read_text())
    names = a.keys() & b.keys() if common else a.keys() | b.keys()
    if not names:
        return [f"{first} and {second}: no numbers to compare were recorded"]
    lines = []
    for name in sorted(names):
        if name not in a or name not in b:
            lines.append(f"{name}: missing in {first if name not in a else second}")
            continue
        if shape(a[name]) != shape(b[name]):
            lines.append(f"{name}: shape {shape(a[name])} in {first}, {shape(b[name])} in {second}")
            continue
        x, y = flattened(a[name]), flattened(b[name])
        if not all(map(math.isfinite, x + y)):
            lines.append(f"{name}: not finite in {first} or {second}")
            continue
        scale = max(map(abs, x + y), default=0.0)
        gap = max((abs(p - q) for p, q in zip(x, y, strict=True)), default=0.0)
        if gap > tolerance * scale:
            lines.append(
                f"{name}: {_shown(first)} and {_shown(second)} differ by {gap / scale:.2e} of the "
                f"largest entry, at most {tolerance:.0e} is allowed"
            )
    return lines


def _shown(file: Path) -> str:
    """Folder and version: the folder says which kernels were used, if not the processor's."""
    return f"{file.parent.name}/{file.stem}"


def main(files: list[Path]) -> int:
    """Print all differences; exit code 1 if there are any or nothing to compare."""
    if len(files) < 2:
        print("fe_numbers: name at least two files to compare", file=sys.stderr)
        return 1
    lines = [line for first, second in pairs(files) for line in differences(first, second)]
    print("\n".join(lines) if lines else f"equal to {TOLERANCE:.0e}: {len(files)} files")
    return int(bool(lines))


if __name__ == "__main__":
    sys.exit(main([Path(argument) for argument in sys.argv[1:]]))
