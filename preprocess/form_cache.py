"""The folder of DOLFINx's compiled forms: our own, and put right after a killed process.

FFCx marks a form under way by a file `NAME.c` and a complete one by `NAME.c.cached`. What a killed
process leaves makes all others wait and fail ("JIT compilation timed out"). Each process of the
preprocessor holds a lock on the folder; one that holds it alone knows that nothing is under way,
and removes what is incomplete.
"""

import contextlib
import os
from pathlib import Path
from typing import IO

from ..solver.math.disk_cache import DiskCache
from ..solver.system.platform import locked

LOCK = "in-use"
_held: list[IO[bytes]] = []  # as long as the process lives


def use_own_folder() -> None:
    """Set DOLFINx's folder of compiled forms; call it before DOLFINx is imported."""
    folder = DiskCache("forms", 0).made("fenics")  # DOLFINx appends this name
    if folder is None:
        return  # DOLFINx uses its own
    os.environ["XDG_CACHE_HOME"] = str(folder.parent)
    with contextlib.suppress(OSError):  # no locks on this file system: nothing is removed
        _held.append(hold(folder))


def hold(folder: Path) -> IO[bytes]:
    """Return the lock of a folder in use; what is incomplete goes if no other process holds it."""
    file = (folder / LOCK).open("ab")
    if locked(file.fileno()):
        _remove_incomplete(folder)
    locked(file.fileno(), shared=True, wait=True)
    return file


def _remove_incomplete(folder: Path) -> None:
    names = set(os.listdir(folder))  # once: a pattern for each form would read it as often
    libraries = {name.split(".")[0] for name in names if name.endswith("so")}
    for source in sorted(name for name in names if name.endswith(".c")):
        name = source.removesuffix(".c")
        if not (f"{source}.cached" in names and name in libraries):
            for file in names:
                if file.startswith(f"{name}."):
                    (folder / file).unlink(missing_ok=True)
