"""A sweep by the ranks of an MPI job on this machine, for tests and measurements."""

import os
import subprocess
import sys
from pathlib import Path
from shutil import which


def with_mpi(folder: Path) -> str | None:
    """PYTHONPATH with mpi4py for this Python: its own, or that of FEniCSx if it fits."""
    if which("mpirun") is None:
        return None
    if (
        subprocess.run([sys.executable, "-c", "import mpi4py.MPI"], capture_output=True).returncode
        == 0
    ):
        return os.environ.get("PYTHONPATH", "")
    other = os.environ.get("FENICSX_PYTHON", "/usr/bin/python3")
    asked = "import sys, mpi4py; print(*sys.version_info[:2], mpi4py.__path__[0])"
    try:
        done = subprocess.run([other, "-c", asked], capture_output=True, text=True)
    except OSError:
        return None
    if done.returncode or done.stdout.split()[:2] != [str(n) for n in sys.version_info[:2]]:
        return None
    folder.mkdir()
    (folder / "mpi4py").symlink_to(done.stdout.split()[2])
    return os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])


def ranks(number: int, *words: str) -> list[str]:
    """Command of a sweep by the ranks of a job, one of which distributes."""
    start = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(number), sys.executable]
    futures = ["-m", "mpi4py.futures", "-m", "plymotion.solver"]
    return [*start, *futures, *words, "--executor", "mpi"]
