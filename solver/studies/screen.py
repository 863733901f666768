"""Messages of the library on standard error: records of the logger "plymotion"."""

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager


class _Screen(logging.Handler):
    """Writes each message to the standard error of that moment, above a progress bar if any."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write one message."""
        text = record.getMessage()
        tqdm = sys.modules.get("tqdm")
        if tqdm is not None and getattr(tqdm.tqdm, "_instances", None):
            tqdm.tqdm.write(text, file=sys.stderr)
        else:
            sys.stderr.write(f"{text}\n")
            sys.stderr.flush()


@contextmanager
def shown(*, steps: bool) -> Iterator[None]:
    """Show messages as long as a block runs: warnings and errors; `steps`: also what is done."""
    logger, handler = logging.getLogger("plymotion"), _Screen()
    before = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.INFO if steps else logging.WARNING)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before[0])
        logger.propagate = before[1]
