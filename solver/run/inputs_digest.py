"""What a result depends on: the run file, its packages, the sources of the solver."""

import hashlib
import json
from pathlib import Path

from ..inputs.case.sources import solver_sha256


def inputs_sha256(file: Path) -> str:
    """Return the digest of all that the result of a run depends on; "" if a part is missing."""
    try:
        content = file.read_bytes()
        digest = hashlib.sha256(solver_sha256().encode() + content)
        table = json.loads(content)
        for entry in (*table["packages"].values(), *table.get("check_packages", {}).values()):
            digest.update((file.parent.parent / entry["file"]).read_bytes())
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return ""
    return digest.hexdigest()
