"""The attack: INT is heard in the background too, and what is over is not tried again."""

import os
import signal
import sys
from pathlib import Path

import pytest
from hostile_profile import RECORD, note_outcome, recorded

# A shell starts commands in the background with INT ignored, and their children inherit that.
if sys.platform != "win32" and signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave out the tests that this attack has passed before it was interrupted."""
    if RECORD:
        over, _ = recorded(Path(RECORD))
        items[:] = [item for item in items if over.get(item.nodeid) != "passed"]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Note the beginning of a test of the attack."""
    note_outcome(item.nodeid, "begun")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note its end; the process that distributes the tests has reports of all, and notes none."""
    if "PYTEST_CURRENT_TEST" in os.environ and (report.when == "call" or not report.passed):
        note_outcome(report.nodeid, report.outcome)
