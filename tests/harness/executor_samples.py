"""Tasks for workers: functions that a process of its own can import."""

import os
import signal
import time
from pathlib import Path

from plymotion.solver.workers.executors import Task

LOG = "PLYMOTION_TEST_LOG"  # name of the variable with the file that portions are noted in


class Numbers:
    """A source of calls f(folder, n) for n of `numbers`; what came back is in `results`."""

    def __init__(self, function, folder, numbers):
        self.function, self.folder = function, str(folder)
        self.left = list(numbers)
        self.results, self.dead, self.lanes = [], [], {}

    def next(self, lane, width):
        if not self.left:
            return None
        number = self.left.pop(0)
        self.lanes.setdefault(lane, []).append(number)
        return Task(self.function, (self.folder, number), number)

    def took(self, task, result):
        self.results.append((task.content, result))

    def lost(self, task):
        self.dead.append(task.content)


def process(folder, number):
    """The process that computes."""
    return os.getpid()


def dies_at_3(folder, number):
    """Kill the process once; square."""
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number**2


def always_dies(folder, number):
    os.kill(os.getpid(), signal.SIGKILL)


def sleeps(folder, number):
    """Say that it is there, then take long."""
    (Path(folder) / f"{number}-{os.getpid()}").touch()
    time.sleep(60.0)


def deadly_portion(order, members, keys):
    """Compute a portion, or die if member 1 is in it."""
    # Here: workers of the other tasks start in a third of the time without the solver.
    from plymotion.solver.studies.sweep.portions import compute_portion

    if any(member.number == 1 for member in members):
        os.kill(os.getpid(), signal.SIGKILL)
    return compute_portion(order, members, keys)


def noted_portion(order, members, keys):
    """Note process and members of a portion once it is computed, and take a while."""
    from plymotion.solver.studies.sweep.portions import compute_portion

    found = compute_portion(order, members, keys)
    time.sleep(0.1)
    line = " ".join(str(word) for word in (os.getpid(), *(m.number for m in members)))
    with open(os.environ[LOG], "a", encoding="ascii") as file:
        file.write(line + "\n")
    return found
