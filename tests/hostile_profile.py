"""How long the attack is, and what it counts: quick, or long with PLYMOTION_ATTACK."""

import json
import os
from pathlib import Path

# A file for the counts: set, the attack is long.
RECORD = os.environ.get("PLYMOTION_ATTACK", "")
LONG = 2 if RECORD else 1


def tries(quick: int, long: int) -> int:
    """Number of tries of a test."""
    return long if RECORD else quick


def count(kind: str, code: object) -> None:
    """Count a try of a kind by its end; kept with PLYMOTION_ATTACK only."""
    if RECORD:
        with Path(RECORD).open("a", encoding="utf-8") as file:
            file.write(json.dumps([kind, str(code)]) + "\n")
