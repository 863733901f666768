"""The sources of the solver, whose change makes what was computed with them out of date."""

from functools import cache
from pathlib import Path

from ...package.common.file_digests import files_sha256

# Rooms of solver/ that have no part in the motion of a mechanism.
_APART = ("__main__.py", "commands", "report")


@cache
def solver_sha256() -> str:
    """Return the digest of the sources of the solver."""
    root = Path(__file__).resolve().parents[2]
    inside = {file.relative_to(root): file for file in root.rglob("*.py")}
    return files_sha256({n.as_posix(): f for n, f in inside.items() if n.parts[0] not in _APART})
