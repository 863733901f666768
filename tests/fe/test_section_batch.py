"""Section files from specifications: what is up to date, errors, kills, shares, MPI ranks."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness.mpi_samples import environment, mpirun, run

from plymotion.preprocess.__main__ import main
from plymotion.solver.package.section.section_file import read_section

ROOT = Path(__file__).resolve().parent.parent.parent
CFRP = {
    "kind": "orthotropic",
    **{"E1": 129.2e9, "E2": 9.4e9, "E3": 9.4e9},
    **{"G12": 5.2e9, "G13": 4.3e9, "G23": 2.5e9},
    **{"nu12": 0.3, "nu13": 0.3, "nu23": 0.22},
    "rho": 1550.0,
}


def bar(angle: float, width: float = 0.06) -> dict[str, Any]:
    """A rectangle of one ply."""
    ply = {"material": "cfrp", "angle_deg": angle}
    return {
        "name": f"bar-{angle:g}",
        "convention": "contour",
        "mesh": {"script": "rectangle", "parameters": {"width": width, "height": 0.015}},
        "materials": {"cfrp": CFRP},
        "regions": {"section": {"plies": [ply], "direction": {"vector": [1.0, 0.0]}}},
    }


BAD = {**bar(0), "regions": {}}


def write(folder: Path, **specs: dict[str, Any]) -> list[Path]:
    files = []
    for name, spec in specs.items():
        files.append(folder / f"{name.replace('_', '-')}.json")
        files[-1].write_text(json.dumps(spec))
    return files


def command(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", "plymotion.preprocess", *map(str, arguments)]


def here(capfd: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str, str]:
    """The command in this process: exit code, output, errors."""
    capfd.readouterr()
    code = main(list(map(str, arguments)))
    return code, *capfd.readouterr()


@pytest.mark.one_end
def test_good_ones_are_made_beside_a_bad_one(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    files = write(tmp_path, good=bar(0), bad=BAD, other=bar(30))
    (tmp_path / "broken.json").write_text("{")
    out = tmp_path / "out"
    code, _, stderr = here(capfd, "section", *files, tmp_path / "broken.json", "--out-dir", out)
    assert code == 2
    assert sorted(path.name for path in out.iterdir()) == ["good.vtkhdf", "other.vtkhdf"]
    errors = [line for line in stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 2, stderr
    assert any("bad.json: section" in line for line in errors)
    assert any("broken.json: not JSON" in line for line in errors)
    assert read_section(out / "other.vtkhdf").K[0, 1] > 0.0


@pytest.mark.one_end
def test_nothing_is_made_twice_and_options_are_inputs(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (spec,) = write(tmp_path, bar=bar(15))
    file = tmp_path / "bar.vtkhdf"

    def told(*options: str) -> str:
        code, stdout, stderr = here(capfd, "section", spec, *options)
        assert code == 0, stderr
        return stdout

    assert told() == "[1/1] bar: 1125 dofs\n"
    assert read_section(file).error_estimate is not None
    os.utime(file, (1, 1))
    assert told() == "[1/1] bar: unchanged\n"
    assert file.stat().st_mtime == 1
    assert told("--no-estimate") == "[1/1] bar: 1125 dofs\n"
    assert read_section(file).error_estimate is None
    spec.write_text(json.dumps(bar(16)))
    assert told("--no-estimate") == "[1/1] bar: 1125 dofs\n"
    assert told("--no-estimate") == "[1/1] bar: unchanged\n"
    assert told("--no-estimate", "--force") == "[1/1] bar: 1125 dofs\n"
    file.write_bytes(file.read_bytes()[:-1000])
    assert told("--no-estimate") == "[1/1] bar: 1125 dofs\n"
    read_section(file)


def lines(text: str) -> list[dict[str, Any]]:
    found = [json.loads(line) for line in text.splitlines()]
    return [line for line in found if "progress" not in line]


@pytest.mark.one_end
def test_killed_batch_goes_on_where_it_was(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    files = write(tmp_path, **{f"bar_{i:02d}": bar(4.0 * i) for i in range(10)})
    line = "section", *files, "--json"
    with subprocess.Popen(
        command(*line),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=environment(),
    ) as process:
        assert process.stdout is not None
        told = []
        while len(told) < 4:
            told += lines(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
    complete = sorted(tmp_path.glob("bar-*.vtkhdf"))
    assert 4 <= len(complete) < 10
    kept = {}
    for file in complete:
        read_section(file)  # sound, whatever was being written
        kept[file] = file.stat().st_mtime_ns
    again = lines(here(capfd, *line)[1])
    status = {Path(one["file"]): one["status"] for one in again}
    assert {file for file, word in status.items() if word == "unchanged"} == set(complete)
    assert sum(word == "built" for word in status.values()) == 10 - len(complete)
    assert all(file.stat().st_mtime_ns == time for file, time in kept.items())


@pytest.mark.one_end
def test_answers_one_by_one(tmp_path: Path) -> None:
    good, bad = write(tmp_path, good=bar(0), bad={"mesh": {"script": "recktangle"}})
    with subprocess.Popen(
        command("section", "-", "--json"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=environment(),
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        status = []
        for path in (bad, good, good):
            process.stdin.write(f"{path}\n")
            process.stdin.flush()
            answer: dict[str, Any] = {"progress": ""}
            while "progress" in answer:
                answer = json.loads(process.stdout.readline())
            assert answer["spec"] == str(path)
            status.append(answer["status"])
        process.stdin.close()
        assert process.wait(20) == 2
    assert status == ["failed", "built", "unchanged"]


@pytest.mark.one_end
@pytest.mark.parametrize("n", [2, 3])
def test_shares_are_the_whole(tmp_path: Path, capfd: pytest.CaptureFixture[str], n: int) -> None:
    files = write(tmp_path, a=bar(0), b=bar(0, 0.05), c=bar(30), d=bar(30, 0.05), e=bar(45))
    made = []
    for k in range(1, n + 1):
        shard = ("--json", "--no-estimate", "--shard", f"{k}/{n}")
        _, stdout, _ = here(capfd, "section", *files, *shard)
        made.append([Path(one["file"]).stem for one in lines(stdout)])
    assert sorted(name for part in made for name in part) == ["a", "b", "c", "d", "e"]
    # In the order of meshes: a share holds few of them.
    assert [name for part in made for name in part] == ["a", "c", "e", "b", "d"]
    assert len(list(tmp_path.glob("*.vtkhdf"))) == 5


def test_ranks_work_on_one_section_together(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    files = write(tmp_path, a=bar(30), bad=BAD, b=bar(45, 0.05))
    files += write(tmp_path, made=bar(60))
    alone, together = tmp_path / "alone", tmp_path / "together"
    to_alone, to_together = (("--no-estimate", "--out-dir", folder) for folder in (alone, together))
    here(capfd, "section", *files, *to_alone)
    here(capfd, "section", files[-1], *to_together)
    done = run([*mpirun(2), *command("section", *files, *to_together)])
    assert done.returncode == 2
    assert done.stdout.splitlines() == [
        "[1/4] a: 1125 dofs",
        "[3/4] made: unchanged",
        "[4/4] b: 1125 dofs",
    ]
    assert done.stderr.count("bad.json: ") == 1, done.stderr
    for name in ("a", "b"):
        K = read_section(alone / f"{name}.vtkhdf").K
        difference = read_section(together / f"{name}.vtkhdf").K - K
        size = np.sqrt(np.diag(K))
        assert np.abs(difference / np.outer(size, size)).max() < 1e-9
    again = here(capfd, "section", files[0], *to_together)
    assert again[:2] == (0, "[1/1] a: unchanged\n")


@pytest.mark.one_end
def test_interrupt_leaves_nothing_half_written(tmp_path: Path) -> None:
    files = write(tmp_path, **{f"bar_{i:02d}": bar(4.0 * i) for i in range(20)})
    with subprocess.Popen(
        command("section", *files, "--json"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=environment(),
    ) as process:
        assert process.stdout is not None
        while not lines(process.stdout.readline()):
            pass
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    assert errors.splitlines()[-1] == "interrupted: files finished before are kept"
    assert {path.suffix for path in tmp_path.iterdir()} == {".json", ".vtkhdf"}
    for path in tmp_path.glob("*.vtkhdf"):
        assert not path.name.startswith(".")
        read_section(path)
