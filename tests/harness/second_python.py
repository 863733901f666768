"""Another interpreter of this machine, whose HDF5 is another version."""

import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import h5py
import pytest

ROOT = Path(__file__).resolve().parents[2]


@cache
def needs_other_python() -> str:
    """Return an interpreter with another HDF5, as the preprocessor's may be; a skip without."""
    for name in (os.environ.get("FENICSX_PYTHON", ""), "/usr/bin/python3"):
        if name and shutil.which(name):
            probe = [name, "-c", "import h5py; print(h5py.version.hdf5_version)"]
            run = subprocess.run(probe, capture_output=True, text=True)
            if run.returncode == 0 and run.stdout.strip() != h5py.version.hdf5_version:
                return name
    pytest.skip("no second Python with another HDF5 here")


def copied_by_other_python(file: Path, module: str, kind: str) -> Path:
    """Read a file and write it again by that interpreter, which finds both equal; the copy."""
    script = (
        "import sys; sys.path.insert(0, sys.argv[3])\n"
        "from samples.package_samples import same\n"
        f"from {module} import read_{kind} as read, write_{kind} as write\n"
        "found = read(sys.argv[1])\n"
        "write(sys.argv[2], found)\n"
        "assert same(found, read(sys.argv[2]))\n"
    )
    copy = file.with_name("copy.vtkhdf")
    subprocess.run(
        [needs_other_python(), "-c", script, str(file), str(copy), str(ROOT / "tests")],
        check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"},
    )
    return copy
