"""Another interpreter of this machine, whose HDF5 is another version."""

import os
import shutil
import subprocess
from functools import cache

import h5py
import pytest


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
