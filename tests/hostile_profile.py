"""How long the attack is: a quick one within `make test`, a long one by `make attack`."""

import os

# Tries of each kind in relation to the quick attack.
LONG = int(os.environ.get("PLYMOTION_ATTACK", "1"))


def tries(quick: int, long: int) -> int:
    """Number of tries of a test."""
    return long if LONG > 1 else quick
