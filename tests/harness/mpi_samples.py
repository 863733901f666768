"""Ranks of an MPI job on this machine: of a sweep, and of one analysis."""

import os
import subprocess
import sys
from pathlib import Path
from shutil import which

ROOT = Path(__file__).resolve().parents[2]

OPEN_MPI = {
    # It asks for these in a container and on a machine with few cores.
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    # Ranks that wait leave the core to others, and none is bound to a busy one.
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}


def with_mpi(folder: Path) -> str | None:
    """PYTHONPATH with mpi4py for this Python: its own, or that of FEniCSx if it fits."""
    if which("mpirun") is None:
        return None
    if (
        subprocess.run([sys.executable, "-c", "import mpi4py.MPI"], capture_output=True).returncode
        == 0
    ):
        return os.environ.get("PYTHONPATH", "")
    other = os.environ.get("FENICSX_PYTHON") or "/usr/bin/python3"  # make exports an empty one
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


def mpirun(number: int) -> list[str]:
    """Start of a program of this Python on some ranks; skips a test where there is no MPI."""
    own = Path(sys.executable).parent / "mpiexec"  # of the wheel, whose MPI it must be
    launcher = str(own) if own.exists() else which("mpirun")
    if launcher is None:
        import pytest

        pytest.skip("no mpirun here")
    return [launcher, "-n", str(number)]


def of_ranks(number: int, *words: str | Path) -> "subprocess.CompletedProcess[str]":
    """A program of this Python on some ranks, with its output."""
    return run([*mpirun(number), sys.executable, *map(str, words)])


def environment() -> dict[str, str]:
    """Of a program that imports what tests share, maybe on ranks."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    return {**os.environ, **OPEN_MPI, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}


def run(line: list[str]) -> "subprocess.CompletedProcess[str]":
    """Such a program with its output."""
    more = {"cwd": ROOT, "env": environment(), "timeout": 300}
    return subprocess.run(line, capture_output=True, text=True, **more)
