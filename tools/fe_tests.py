"""Run the FE tests on every available DOLFINx, then compare the numbers.

The distribution's packages and the wheel are the oldest and the newest supported
version. Each one is installed if possible; otherwise the reason is printed. The tests record the
numbers they computed in build/fe-numbers/, one file per version; equal inputs must give equal
numbers (tools/fe_numbers.py).
"""

import os
import shutil
import sys
import time

from fe_numbers import differences, pairs
from fenicsx_sources import (
    APT_INSTALL,
    ROOT,
    SYSTEM_PYTHON,
    Report,
    from_system,
    from_wheel,
    probe,
    reasons,
    usable,
)
from interpreters import output, run, say

NUMBERS = ROOT / "build" / "fe-numbers"


def ends() -> list[tuple[str, Report | str]]:
    """(name, report or reason for its absence) for each DOLFINx to test."""
    found: list[tuple[str, Report | str]] = [
        ("distribution", from_system()),
        ("wheel", from_wheel()),
    ]
    if wish := os.environ.get("FENICSX_PYTHON"):
        report = probe(wish)
        known = {entry["python"] for _, entry in found if isinstance(entry, dict)}
        if not usable(report):
            found.append(("FENICSX_PYTHON", f"{wish}: {reasons(report)}"))
        elif report["python"] not in known:
            found.append(("FENICSX_PYTHON", report))
    return found


def has_pytest(python: str) -> bool:
    """True if this interpreter has pytest, after installing it if that is possible."""
    if output([python, "-c", "import pytest"]) is not None:
        return True
    if python == SYSTEM_PYTHON:
        run([APT_INSTALL, "python3-pytest"])
    elif output([python, "-c", "import sys; sys.exit(sys.prefix == sys.base_prefix)"]) is not None:
        run([python, "-m", "pip", "install", "--quiet", "pytest"])
    return output([python, "-c", "import pytest"]) is not None


def main(arguments: list[str]) -> int:
    """Run pytest with each version; exit code 1 if one fails, numbers differ, or none could run."""
    # Only numbers of this run are compared: an old file could hide a difference.
    shutil.rmtree(NUMBERS, ignore_errors=True)
    summary: list[str] = []
    failed = False
    ran = 0
    for name, report in ends():
        if isinstance(report, str):
            summary.append(f"{name}: SKIPPED, {report}")
            continue
        title = f"DOLFINx {report['dolfinx']} ({name}, {report['python']})"
        if not has_pytest(report["python"]):
            summary.append(f"{title}: SKIPPED, it has no pytest and none could be installed")
            continue
        print(f"\n== FE tests on {title}", flush=True)
        start = time.monotonic()
        code = run([report["python"], "-m", "pytest", "-q", "tests/fe", *arguments])
        seconds = time.monotonic() - start
        ran += 1
        failed = failed or code != 0
        summary.append(f"{title}: {'passed' if code == 0 else 'FAILED'} in {seconds:.0f} s")
    failed = compare(ran, summary) or failed or ran == 0
    print()
    for line in summary:
        say(line)
    return int(failed)


def compare(ran: int, summary: list[str]) -> bool:
    """Compare the recorded numbers of all versions; True if any differ."""
    files = sorted(NUMBERS.glob("*.json"))
    if ran < 2:
        summary.append("numbers between versions: NOT COMPARED, fewer than two versions ran")
        return False
    if len(files) != ran:
        summary.append(f"numbers between versions: FAILED, {ran} ran but {len(files)} recorded")
        return True
    lines = [line for first, second in pairs(files) for line in differences(first, second)]
    for line in lines:
        print(line, file=sys.stderr)
    result = f"FAILED, {len(lines)} differences" if lines else "equal"
    summary.append(f"numbers between {', '.join(file.stem for file in files)}: {result}")
    return bool(lines)


if __name__ == "__main__":
    os.chdir(ROOT)
    os.environ["PYTHONPATH"] = str(ROOT)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(main(sys.argv[1:]))
