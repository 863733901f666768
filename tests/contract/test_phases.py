"""Phases of `make test`: side by side, output in one piece, failures last, Ctrl-C ends all."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from harness.processes import this_python

MAKEFILE = """
good: ; @echo one; sleep 0.2; echo two; echo '1.50s call     tests/test_a.py::test_long'
bad: ; @echo three; exit 3
long: ; @echo waiting; sleep 60
tests: ; @echo 'FAILED tests/test_a.py::test_b[1 2]'; sleep 0.5; \
    echo 'FAILED tests/test_a.py::test_b[1 2] - AssertionError'; false
"""


@pytest.fixture(scope="module")
def side_by_side(tools: Path) -> ModuleType:
    import side_by_side

    return side_by_side


def job(side_by_side: ModuleType, code: str, cores: int = 1, **environment: str) -> Any:
    command = (sys.executable, "-c", "import os, sys, time; " + code)
    return side_by_side.Job(code, command, cores, environment)


def test_jobs_run_on_the_cores_that_there_are(side_by_side: ModuleType) -> None:
    running: list[int] = []
    most: list[int] = []

    def started(job: Any) -> None:
        running.append(job.cores)
        most.append(sum(min(cores, 3) for cores in running))

    jobs = [job(side_by_side, "time.sleep(0.1)", cores) for cores in (2, 2, 1, 9, 1)]
    done = side_by_side.run_all(
        jobs, 3, started=started, ended=lambda done: running.remove(done.job.cores)
    )
    assert [each.job for each in done] == jobs
    assert [each.code for each in done] == [0] * 5
    assert len(most) == 5
    assert max(most) == 3


def test_a_job_of_no_core_runs_beside_others_but_not_beside_one_of_too_many(
    side_by_side: ModuleType,
) -> None:
    beside: dict[int, list[int]] = {}
    running: list[int] = []

    def started(job: Any) -> None:
        beside[job.cores] = list(running)
        running.append(job.cores)

    jobs = [job(side_by_side, "time.sleep(0.2)", cores) for cores in (9, 2, 0, 1)]
    side_by_side.run_all(
        jobs, 2, started=started, ended=lambda done: running.remove(done.job.cores)
    )
    assert beside[9] == beside[2] == []
    assert beside[0] == [2]
    assert 2 not in beside[1]


def test_jobs_of_no_core_run_one_after_the_other(side_by_side: ModuleType) -> None:
    jobs = [job(side_by_side, "time.sleep(0.1)", cores) for cores in (2, 0, 0, 0)]
    running: list[Any] = []
    beside: list[list[int]] = []

    def started(job: Any) -> None:
        beside.append([other.cores for other in running])
        running.append(job)

    side_by_side.run_all(jobs, 2, started=started, ended=lambda done: running.remove(done.job))
    assert [cores.count(0) for cores in beside] == [0] * 4


def test_time_on_the_cores_counts_that_of_all_processes(side_by_side: ModuleType) -> None:
    """Of the job and of what it starts; waiting takes none."""
    busy = "end = time.process_time() + 0.3\nwhile time.process_time() < end: pass"
    code = f"import subprocess; subprocess.run([sys.executable, '-c', {'import time; ' + busy!r}])"
    jobs = [job(side_by_side, code), job(side_by_side, "time.sleep(0.5)")]
    works, waits = side_by_side.run_all(jobs, 2)
    assert works.cpu >= 0.3
    assert 0.0 < waits.cpu < 0.3


def test_results_tell_code_and_output(side_by_side: ModuleType) -> None:
    jobs = [
        job(side_by_side, "print('out', flush=True); print('err', file=sys.stderr); sys.exit(3)"),
        job(side_by_side, "print(os.environ['WORD'])", WORD="own"),
        side_by_side.Job("none", ("no-such-program",)),
    ]
    shown: list[Any] = []
    done = side_by_side.run_all(jobs, 2, ended=shown.append)
    assert [(each.code, each.output) for each in done[:2]] == [(3, "out\nerr\n"), (0, "own\n")]
    assert done[2].code == 127
    assert "no-such-program" in done[2].output
    assert sorted(map(id, shown)) == sorted(map(id, done))


def test_a_job_waits_for_another(side_by_side: ModuleType) -> None:
    first = job(side_by_side, "time.sleep(0.1)")
    second = side_by_side.Job("second", (sys.executable, "-c", ""), after=first)
    third = job(side_by_side, "pass")
    ended: list[Any] = []
    done = side_by_side.run_all(
        [first, second, third], 3, ended=lambda done: ended.append(done.job)
    )
    assert [each.job for each in done] == [first, second, third]
    assert ended.index(first) < ended.index(second)


def phases(folder: Path, tools: Path, *targets: str) -> "subprocess.Popen[str]":
    (folder / "Makefile").write_text(MAKEFILE)
    return subprocess.Popen(
        [sys.executable, "-u", str(tools / "phases.py"), "make", *targets],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={key: value for key, value in os.environ.items() if not key.startswith("MAKE")},
    )


def test_output_of_a_failure_comes_last_and_fails_all(tmp_path: Path, tools: Path) -> None:
    process = phases(tmp_path, tools, "bad", "good")
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 1, errors
    begin = [output.index(words) for words in ("one\ntwo\n", "three\n", "where the time went")]
    assert begin == sorted(begin)
    end = output[begin[-1] :]
    times = r"in \d+ s, CPU \d+ s\n"
    assert re.search(f"^bad +FAILED {times}good +passed {times}", end, re.MULTILINE)
    assert "    1.5  tests/test_a.py::test_long\nall " in end


def test_what_fails_is_named_at_once_and_once(tmp_path: Path, tools: Path) -> None:
    process = phases(tmp_path, tools, "tests", "bad")
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 1, errors
    while_running = output[: output.index("==== make tests\n")].splitlines()
    test = "==== make tests: FAILED tests/test_a.py::test_b[1 2]"
    assert while_running.count(test) == 1
    assert while_running.index(test) < while_running.index(
        "==== make tests: FAILED, its output is at the end"
    )
    assert "==== make bad: make: *** [Makefile:3: bad] Error 3" in while_running


def test_lines_are_told_while_a_job_runs(side_by_side: ModuleType) -> None:
    code = "print('a', flush=True); time.sleep(0.4); print('bc'); print('no newline', end='')"
    told: list[tuple[str, float]] = []
    (done,) = side_by_side.run_all(
        [job(side_by_side, code)], 1, wrote=lambda job, line: told.append((line, time.monotonic()))
    )
    assert done.output == "a\nbc\nno newline"
    assert [line for line, _ in told] == ["a", "bc"]
    assert told[1][1] - told[0][1] > 0.2


def test_a_failed_test_is_named_while_the_others_run(repository: Path, tmp_path: Path) -> None:
    (tmp_path / "test_two.py").write_text("def test_a(): assert 0\ndef test_b(): pass\n")
    (tmp_path / "conftest.py").write_text((repository / "tests/conftest.py").read_text())
    words = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "--tb=no", "-c", "/dev/null"]
    done = this_python(*words, "--rootdir", tmp_path, "test_two.py", cwd=tmp_path)
    lines = done.stdout.splitlines()
    assert lines[:3] == ["F", "FAILED test_two.py::test_a", ". " + lines[2][2:]], done.stdout


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_all_phases(tmp_path: Path, tools: Path, number: signal.Signals) -> None:
    process = phases(tmp_path, tools, "good", "long", "long")
    assert process.stdout is not None
    for line in process.stdout:
        if line == "two\n":
            break
    start = time.monotonic()
    process.send_signal(number)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert time.monotonic() - start < 9.0  # not by SIGKILL after a wait
    assert "interrupted" in errors
    assert output.count("waiting") >= 1  # what they wrote so far


def test_slowest_tests_with_their_set_up(tools: Path) -> None:
    import phases

    output = "x\n0.50s setup    t.py::a[1 2]\n2.00s call     t.py::b\n1.00s call     t.py::a[1 2]\n"
    assert phases.slowest(output) == [(2.0, "t.py::b"), (1.5, "t.py::a[1 2]")]
    many = "".join(f"{n}.00s call     t.py::t{n}\n" for n in range(20))
    assert [seconds for seconds, _ in phases.slowest(many)] == [float(n) for n in range(19, 9, -1)]
