"""What a result depends on: the run file, its packages, the sources of the solver."""

import hashlib
import json
from functools import cache
from pathlib import Path

# Rooms of solver/ that have no part in the motion of a mechanism.
_APART = ("__main__.py", "commands", "report")


@cache
def solver_sha256() -> str:
    """Return the digest of the sources of the solver."""
    root = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for source in sorted(root.rglob("*.py")):
        inside = source.relative_to(root)
        if inside.parts[0] not in _APART:
            digest.update(inside.as_posix().encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()


def inputs_sha256(file: Path) -> str:
    """Return the digest of all that the result of a run depends on; "" if a part is missing."""
    try:
        content = file.read_bytes()
        digest = hashlib.sha256(solver_sha256().encode() + content)
        for entry in json.loads(content)["packages"].values():
            digest.update((file.parent.parent / entry["file"]).read_bytes())
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return ""
    return digest.hexdigest()
