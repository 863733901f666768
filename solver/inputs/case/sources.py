"""The sources of the solver, whose change makes what was computed with them out of date."""

import hashlib
from functools import cache
from pathlib import Path

# Rooms of solver/ that have no part in the motion of a mechanism.
_APART = ("__main__.py", "commands", "report")


@cache
def solver_sha256() -> str:
    """Return the digest of the sources of the solver."""
    root = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for source in sorted(root.rglob("*.py")):
        inside = source.relative_to(root)
        if inside.parts[0] not in _APART:
            digest.update(inside.as_posix().encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()
