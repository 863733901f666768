"""The attack: signals are heard in the background too, and what is over is not tried again."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness.forks import forks
from harness.hostile_profile import RECORD, note_outcome, recorded

# Commands in the background ignore INT, and with nohup HUP, and their children inherit that; what
# has a handler here has none in them.
for name in ("SIGINT", "SIGHUP"):
    number = getattr(signal, name, None)  # no HUP on Windows
    if number is not None and signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, lambda *_: None)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave out the tests that this attack has passed before it was interrupted."""
    if RECORD:
        over, _ = recorded(Path(RECORD))
        items[:] = [item for item in items if over.get(item.nodeid) != "passed"]


@pytest.fixture(scope="session", autouse=True)
def forks_end() -> Iterator[None]:
    """Wait for the process in whose forks commands are struck."""
    yield
    forks.end()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Note the beginning of a test of the attack."""
    note_outcome(item.nodeid, "begun")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note its end; the process that distributes the tests has reports of all, and notes none."""
    if "PYTEST_CURRENT_TEST" in os.environ and (report.when == "call" or not report.passed):
        note_outcome(report.nodeid, report.outcome)
