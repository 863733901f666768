"""Find a Python with FEniCSx, or install one: find_fenicsx.py build/fenicsx.env.

Tries $FENICSX_PYTHON, python3, /usr/bin/python3 and the environments of the
project (.fenicsx-*), by importing the packages. If none is usable: Debian's packages,
conda, or the wheel. The choice is written as a line that shells can read.
"""

import os
import shlex
import sys
from pathlib import Path

from fenicsx_sources import ROOT, SYSTEM_PACKAGES, from_conda, from_system, from_wheel
from interpreters import say

from plymotion.solver.workers.interpreter import (
    Report,
    present,
    probe,
    reasons,
    usable,
)

ADVICE = f"""\
setup: no FEniCSx here and none could be installed. One of these helps:
  Debian, Ubuntu:  apt-get install --no-install-recommends {" ".join(SYSTEM_PACKAGES)}
  conda:           have micromamba, mamba or conda on PATH, then  make fenicsx
  Linux x86-64:    have a Python 3.12, 3.13 or 3.14 on PATH, then  make fenicsx
  elsewhere:       make FENICSX_PYTHON=/path/to/python ...   (real-scalar DOLFINx, slepc4py, gmsh)
  without FEniCSx: make <case> PACKAGES=shipped   (uses the modal packages of the repository)"""


def installed() -> Report | None:
    """FEniCSx from the first available source, or None with the reasons printed."""
    for source in (from_system, from_conda, from_wheel):
        result = source()
        if isinstance(result, dict):
            return result
        say(f"FEniCSx: {result}")
    return None


def record(report: Report, path: Path) -> None:
    """Write the choice: the variables FENICSX_PYTHON and DOLFINX_VERSION for a shell."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(
        f"FENICSX_PYTHON={shlex.quote(report['python'])}\n"
        f"DOLFINX_VERSION={shlex.quote(report['dolfinx'])}\n"
    )
    temporary.replace(path)


def main(path: Path) -> int:
    """Record the choice in `path`; exit code 1 if there is none."""
    report: Report | None
    if wish := os.environ.get("FENICSX_PYTHON"):
        report = probe(wish)
        if not usable(report):
            say(f"FENICSX_PYTHON={wish} cannot be used: {reasons(report)}")
            return 1
    else:
        report = present([ROOT])[0] or installed()
    if report is None:
        print(ADVICE, file=sys.stderr)
        return 1
    record(report, path)
    say(f"FEniCSx: {report['python']}, DOLFINx {report['dolfinx']}")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
