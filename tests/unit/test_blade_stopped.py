"""`plymotion blade` is stopped in the middle; the same command goes on from there.

By Ctrl-C. Its sections are a batch as that of `plymotion section`, which is also killed:
tests/contract/test_section_cli.py.
"""

import csv
import os
import signal
import subprocess
import sys
import time

import pytest
from harness.struck_samples import narrow_pipe
from samples.blade_samples import write_blade

from plymotion.solver.__main__ import main

COUNT = 6


@pytest.mark.usefixtures("fenicsx")
def test_a_stopped_blade_goes_on_where_it_was(repository, tmp_path, capsys):
    file, out = write_blade(tmp_path), tmp_path / "out"
    words = ["blade", str(file), "--stations", str(COUNT), "-o", str(out), "--no-estimate"]

    def made():
        return {path: path.stat().st_mtime_ns for path in out.glob("sections/*/r*.vtkhdf")}

    reader, writer = narrow_pipe(120)  # the batch cannot end before the signal
    with subprocess.Popen(
        [sys.executable, "-m", "plymotion", *words],
        stderr=writer,
        stdout=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(repository)},
    ) as process:
        os.close(writer)
        end = time.monotonic() + 240.0
        while len(made()) < 2:
            assert time.monotonic() < end
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        with open(reader, encoding="utf-8") as stream:
            errors = stream.read()
        process.wait(120)
    assert "[1/6] r00000: built" in errors  # progress
    assert process.returncode == 130
    assert f"of {COUNT} sections are complete and kept" in errors
    assert not (out / "blade.csv").exists()
    kept = made()
    assert 2 <= len(kept) < COUNT
    assert main([*words, "--quiet"]) == 0
    assert f"{len(kept)} unchanged" in capsys.readouterr().out
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    with (out / "blade.csv").open(newline="") as stream:
        assert len(list(csv.DictReader(stream))) == COUNT
