"""Lines that say what a long command is doing, where there is no progress bar."""

import sys
import threading
import time

from ..studies.exit_codes import bar_is_shown

FIRST_S = 1.5  # a user waits two seconds for a sign of life
LONGER = 2.0  # time from one line to the next over that before


class Heartbeat:
    """Prints the latest step and the time on standard error, less and less often."""

    def __init__(self, doing: str = "starting") -> None:
        self.doing = doing
        self._begin = time.monotonic()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._beat, daemon=True)
        self._thread.start()

    def _beat(self) -> None:
        pause = FIRST_S
        while not self._ended.wait(pause):
            seconds = time.monotonic() - self._begin
            if not bar_is_shown():
                print(f"{self.doing}, {seconds:.0f} s", file=sys.stderr, flush=True)
            pause *= LONGER

    def close(self) -> None:
        """Print no more."""
        self._ended.set()
        self._thread.join()
