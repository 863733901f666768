"""Run targets of make side by side and say where the time went.

    phases.py MAKE TARGET[:CORES] ...

A target runs as soon as its cores are free, the first ones first. CORES is 1 unless the argument
says otherwise; one with more than there are runs alone. Targets with 0 run beside others, one after
the other: they fill the cores while the others wait.

What fails is named at once: a test, or a target of a make inside. The output of each is printed in
one piece when it ends; of those that fail, at the end. The last lines are a table of the wall and
CPU times and the slowest tests of each target, read from what `pytest --durations` printed. The
exit code is 1 if a target fails, 130 after Ctrl-C.
"""

import os
import re
import sys
import time

from side_by_side import Done, Job, run_all

SLOWEST = 10  # tests of each target
# What pytest (tests/conftest.py), fe_tests.py and make write when something fails.
FAILURE = re.compile(r"(?:(?:FAILED|ERROR) tests/.*?(?= - |$))|make\S*: \*\*\* \[.*")
DURATION = re.compile(r"^([0-9.]+)s (?:call|setup|teardown) +(\S.*)$", re.MULTILINE)


def failure(line: str) -> str | None:
    """What a line of output says to have failed, without the reason; None for other lines."""
    found = FAILURE.match(line)
    return found[0] if found else None


def slowest(output: str) -> list[tuple[float, str]]:
    """(wall time [s], test) of the slowest tests in the output of a target, the slowest first.

    Set-up and tear-down belong to the test that they were done for.
    """
    total: dict[str, float] = {}
    for seconds, test in DURATION.findall(output):
        total[test] = total.get(test, 0.0) + float(seconds)
    ranked = sorted(((seconds, test) for test, seconds in total.items()), reverse=True)
    return ranked[:SLOWEST]


def table(results: list[Done], seconds: float) -> str:
    """Wall time, CPU time and slowest tests of each target, and the times of all."""
    lines = ["==== where the time went (wall s; targets run side by side)"]
    for done in results:
        result = "passed" if done.code == 0 else "FAILED"
        lines.append(f"{done.job.title:<12} {result} in {done.seconds:.0f} s, CPU {done.cpu:.0f} s")
        lines += [f"  {each:7.1f}  {test}" for each, test in slowest(done.output)]
    cpu = sum(done.cpu for done in results)
    lines.append(f"{'all':<12} in {seconds:.0f} s, CPU {cpu:.0f} s")
    return "\n".join(lines)


def job(make: str, target: str) -> Job:
    """The job of an argument TARGET[:CORES]; make goes on with other files after a failure."""
    name, _, cores = target.partition(":")
    return Job(name, (*make.split(), "--keep-going", name), int(cores or 1))


def main(arguments: list[str]) -> int:
    """Run all targets; the exit code."""
    make, *targets = arguments
    start = time.monotonic()
    failed: list[Done] = []
    named: set[tuple[str, str]] = set()

    def name(job: Job, line: str) -> None:
        what = failure(line)
        if what is not None and (job.title, what) not in named:
            named.add((job.title, what))
            print(f"==== make {job.title}: {what}", flush=True)

    def show(done: Done) -> None:
        print(f"\n==== make {done.job.title}\n{done.output}", end="", flush=True)

    def ended(done: Done) -> None:
        if done.code == 0:
            show(done)
        else:
            failed.append(done)
            print(f"==== make {done.job.title}: FAILED, its output is at the end", flush=True)

    cores = os.cpu_count() or 1
    try:
        results = run_all(
            [job(make, target) for target in targets],
            cores,
            started=lambda job: print(f"==== make {job.title} begins", flush=True),
            ended=ended,
            wrote=name,
        )
    except KeyboardInterrupt:
        for done in failed:
            show(done)
        print("\ninterrupted: all targets that ran were ended", file=sys.stderr)
        return 130
    for done in failed:
        show(done)
    print(f"\n{table(results, time.monotonic() - start)}")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
