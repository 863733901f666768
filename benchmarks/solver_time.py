"""Time of the whole benchmark: what each part may take, and when it stops to repeat."""

import time
from collections.abc import Iterator

# Of the whole time, by part. The first round of a part is always done.
SHARES = {
    "double_pendulum": 0.65,
    "ensemble": 0.08,
    "chain": 0.2,
    "limit": 0.02,
    "memory": 0.05,
}


def deadline(part: str, minutes: float) -> float:
    """Until when a part that begins now may repeat its runs, as `time.perf_counter` counts."""
    return time.perf_counter() + 60.0 * minutes * SHARES[part]


def rounds_until(rounds: int, end: float) -> Iterator[int]:
    """Yield up to so many rounds, no further ones after `end`; at least one."""
    for k in range(rounds):
        if k and time.perf_counter() > end:
            return
        yield k
