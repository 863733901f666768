"""Runs of many output times: the same results as in memory, in memory that does not grow."""

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from harness.processes import this_python
from samples.case_samples import HEAD, SOLVER, case_runs, rigid

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.integrators.generic import drive
from plymotion.solver.math import rows
from plymotion.solver.math.rows import ComputedRows, LongRows, StoredRows
from plymotion.solver.package.common.files import RECORD
from plymotion.solver.results import RunResult, datasets, read_result, write_result
from plymotion.solver.results import file as writer
from plymotion.solver.results.datasets import Datasets, blocks, read_array
from plymotion.solver.run.execution import execute, read_run, run_file

SIGNALS = {
    "turn": {"kind": "joint", "joint": "elbow", "coordinate": "angle"},
    "orientation": {"kind": "orientation", "at": "hand.tip", "component": "z"},
    "pull": {"kind": "reaction", "joint": "elbow", "quantity": "force", "component": "magnitude"},
    "bend": {"kind": "deflection", "at": "arm.mid", "component": "y"},
    "stress": {"kind": "ply_stress", "body": "hand", "x": 0.1, "component": "11"},
}


def both(
    monkeypatch: pytest.MonkeyPatch, file: Path, **keys: Any
) -> tuple[tuple[RunResult, dict[str, Any]], tuple[RunResult, dict[str, Any]]]:
    """Result and summary of a run in memory, and through files with windows of 40 rows."""
    spec = read_run(file).changed({f"solver.{key}": value for key, value in keys.items()})
    table = {f"signals.{name}": value for name, value in SIGNALS.items()}
    spec = spec.changed(table)
    plain = execute(spec, progress=False)
    monkeypatch.setattr(drive, "IN_MEMORY", 0)
    monkeypatch.setattr(drive, "WINDOW", 40 * 8 * (plain[0].q.shape[1] + plain[0].v.shape[1] + 1))
    monkeypatch.setattr(rows, "BLOCK", 10_000)
    return plain, execute(spec, progress=False)


def same(plain: RunResult, long: RunResult) -> None:
    """The states to the bit, all else to the rounding of matrix products."""
    assert isinstance(long.q, LongRows)
    assert isinstance(long.node_positions_G, LongRows)
    assert np.array_equal(plain.t, long.t)
    assert np.array_equal(plain.q, long.q)
    assert np.array_equal(plain.v, long.v)
    arrays = [("multipliers", plain.multipliers, long.multipliers)]
    arrays += [("nodes", plain.node_positions_G, long.node_positions_G)]
    arrays += [(n, plain.energies[n], long.energies[n]) for n in plain.energies]
    arrays += [
        (one.name, one.values, two.values)
        for one, two in zip(plain.signals, long.signals, strict=True)
    ]
    for name, one, two in arrays:
        scale = np.abs(one).max()
        np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-12 * scale, err_msg=name)


@pytest.mark.parametrize("integrator", ["radau", "rk8", "gear"])
def test_a_window_at_a_time_is_the_same_run(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, integrator: str
) -> None:
    """Several windows in a step, several steps in a window, blocks that divide the signals."""
    file = case_runs(repository, "double-pendulum", tmp_path / "build") / "layup-1.json"
    keys = {"t_end": 0.01, "output_step": 2e-5, "integrator": integrator, "rtol": 1e-4}
    (plain, told), (long, told_long) = both(monkeypatch, file, **keys)
    assert len(plain.t) == 501
    same(plain, long)
    for key in ("steps", "rejected"):
        assert told["cost"][key] == told_long["cost"][key]
    for key in told["checks"].keys() - {"modes_used"}:
        one, two = told["checks"][key], told_long["checks"][key]
        assert two == pytest.approx(one, rel=1e-6, abs=1e-15), key
    assert [w["code"] for w in told["warnings"]] == [w["code"] for w in told_long["warnings"]]
    write_result(tmp_path / "result.vtkhdf", long)
    same_file = read_result(tmp_path / "result.vtkhdf")
    assert np.array_equal(same_file.q, plain.q)
    assert np.array_equal(same_file.node_positions_G, np.asarray(long.node_positions_G))
    for name, signal in told["signals"].items():
        assert signal["max"] == pytest.approx(told_long["signals"][name]["max"], rel=1e-9), name
        assert signal["t_max"] == told_long["signals"][name]["t_max"], name


def test_positions_that_are_left_out_follow_from_the_coordinates(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beyond 100 MB (here 1 MB) the file has no positions of nodes; the reader computes them."""
    file = case_runs(repository, "double-pendulum", tmp_path / "build") / "layup-1.json"
    spec = read_run(file).changed({"solver.t_end": 0.1, "solver.output_step": 1e-4})
    result, _ = execute(spec, progress=False)
    assert result.node_positions_G.nbytes > 1_000_000
    monkeypatch.setattr(writer, "MOST_STORED", 1_000_000)
    sizes = {}
    for name, every in (("auto", False), ("all", True)):
        path = tmp_path / f"{name}.vtkhdf"
        write_result(path, result, all_positions=every)
        sizes[name] = path.stat().st_size
        with h5py.File(path) as written:
            assert ("node_positions_G" in written["results"]) == every
        found = read_result(path)
        assert isinstance(found.node_positions_G, LongRows) != every
        assert np.array_equal(found.q, result.q)
        np.testing.assert_allclose(found.node_positions_G, result.node_positions_G, atol=1e-14)
    assert sizes["auto"] < sizes["all"] - 100_000
    # A key of the case says it for a run.
    table = json.loads(file.read_text())
    for key, every in (("auto", False), ("all", True)):
        changed = {"t_end": 0.1, "output_step": 1e-4, "node_positions": key}
        table["mechanism"]["solver"] |= changed
        file.with_name(f"{key}.json").write_text(json.dumps(table))
        run_file(file.with_name(f"{key}.json"), tmp_path / key, progress=False)
        with h5py.File(tmp_path / key / "result.vtkhdf") as written:
            assert ("node_positions_G" in written["results"]) == every


def test_blocks_are_all_rows_once() -> None:
    """Blocks follow one another, from the first row to the last, whatever the width."""
    for shape in ((6_000_001,), (6_000_001, 22), (9000, 150, 3), (500, 40_000), (3, 7), (10, 0)):
        parts = list(blocks(shape))
        assert (parts[0][0], parts[-1][1]) == (0, shape[0])
        assert all(one[1] == two[0] for one, two in pairwise(parts))
        width = 8 * int(np.prod(shape[1:]))
        assert all((end - first) * width <= 2_000_000 for first, end in parts)


def test_long_rows_are_stored_as_they_are(tmp_path: Path) -> None:
    """Arrays over time are contiguous: compression took more time than the integration."""
    values = np.sin(np.linspace(0.0, 10.0, 303_000)).reshape(101, 3000)
    with h5py.File(tmp_path / "file.h5", "w") as file:
        computed = ComputedRows(values.shape, lambda a, b: values[a:b])
        dataset = Datasets().put(file, "moving", computed, "m", "G", "positions")
        assert values.nbytes > datasets.LARGE
        assert dataset.compression is None
        assert dataset.chunks is None
        assert dataset.id.get_storage_size() == values.nbytes
        assert np.array_equal(dataset[()], values)


def test_large_arrays_are_mapped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is read of a large array takes no memory until it is used; changes stay in memory."""
    path, values = tmp_path / "file.h5", np.linspace(0.0, 1.0, 400_000).reshape(-1, 4)
    monkeypatch.setattr(datasets, "MAPPED", 2_000_000)
    with h5py.File(path, "w") as file:
        file["plain"] = values
        file.create_dataset("packed", data=values, compression="gzip")
    with h5py.File(path) as file:
        plain, packed = (read_array(file[name]) for name in ("plain", "packed"))
    assert isinstance(plain.base, np.memmap)
    assert packed.base is None
    for found in (plain, packed):
        assert type(found) is np.ndarray
        assert np.array_equal(found, values)
        found[0] = 7.0
    path.unlink()  # as a new result does, by a rename
    assert np.array_equal(plain[1:], values[1:])
    assert plain[0, 0] == 7.0


def test_one_step_over_many_windows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A free flight is a few long steps: each has thousands of output times."""
    (tmp_path / "case.toml").write_text(
        HEAD
        + rigid("stone", 1.0, 0.1, {"tip": [0.5, 0, 0]}, velocity=[3.0, 0, 0])
        + SOLVER.format(t_end=10.0, step=1e-3, more="").replace("rk8", "radau")
    )
    write_case(load_case(tmp_path / "case.toml"), tmp_path)
    spec = read_run(tmp_path / "runs/base.json")
    plain, told = execute(spec, progress=False)
    monkeypatch.setattr(drive, "IN_MEMORY", 0)
    monkeypatch.setattr(drive, "WINDOW", 100 * 8 * 14)
    long, told_long = execute(spec, progress=False)
    assert told["cost"]["steps"] < 100 < 10_001 == len(plain.t)
    assert np.array_equal(plain.q, np.asarray(long.q))
    assert told["cost"]["steps"] == told_long["cost"]["steps"]


def test_rows_after_a_stop_are_dropped(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = (
        case_runs(repository, "double-pendulum-limits", tmp_path / "build")
        / "isotropic-soft-free.json"
    )
    (plain, told), (long, told_long) = both(monkeypatch, file, output_step=1e-4)
    assert told["status"] == told_long["status"] == "stopped"
    assert told["t_end"] == told_long["t_end"] == plain.t[-1] < 1.0
    same(plain, long)


def test_stored_rows_are_read_like_an_array(tmp_path: Path) -> None:
    numbers = np.arange(60.0).reshape(20, 3)
    stored = StoredRows((3,), tmp_path)
    stored.append(numbers[:7])
    stored.append(numbers[7:])
    assert list(tmp_path.iterdir()) == []  # it has no name, so nothing is ever left
    keys: list[Any] = [3, -1, slice(2, 9), slice(None), slice(0, 20, 6), np.array([1, 2, 3, 9, 4])]
    keys += [(slice(None), slice(1, 3)), (slice(4, 5), 0), (2, 1), numbers[:, 0] > 30.0]
    for key in keys:
        assert np.array_equal(stored[key], numbers[key]), key
    stored.cut(5)
    stored.append(numbers[:1])
    assert np.array_equal(stored, np.concatenate([numbers[:5], numbers[:1]]))
    with pytest.raises(IndexError):
        stored[6]


PENDULUM = (
    "gravity = [0.0, -9.81, 0.0]\n"
    + rigid("rod", 1.0, [0.01, 0.4, 0.4], {"root": [-0.5, 0, 0], "tip": [0.5, 0, 0]})
    + "[ground.O]\nposition = [-0.5, 0, 0]\n"
    + '[joints.hinge]\nkind = "revolute"\nbetween = ["ground.O", "rod.root"]\naxis = [0, 0, 1]\n'
    + '[signals.turn]\nkind = "joint"\njoint = "hinge"\ncoordinate = "angle"\n'
    + '[signals.tip]\nkind = "position"\nat = "rod.tip"\ncomponent = "y"\n'
)


@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="reads the memory from Linux")
def test_memory_does_not_grow_with_output_times(tmp_path: Path) -> None:
    """200,000 output times have 50 MB of numbers. What grows are the times, 8 bytes each."""
    file = tmp_path / "case.toml"
    file.write_text(
        HEAD + PENDULUM + SOLVER.format(t_end=2.0, step=1e-3, more="").replace("rk8", "radau")
    )
    write_case(load_case(file), tmp_path / "build")
    base = (tmp_path / "build/runs/base.json").read_text()
    peaks = []
    for name, step in (("few", 4e-5), ("many", 1e-5)):
        run = tmp_path / f"build/runs/{name}.json"
        run.write_text(base.replace('"output_step": 0.001', f'"output_step": {step}'))
        out = tmp_path / name
        code = (
            "import sys\nfrom plymotion.solver.__main__ import main\n"
            f"code = main(['run', {str(run)!r}, '--out', {str(out)!r}, '--quiet'])\n"
            "print(next(x for x in open('/proc/self/status') if x.startswith('VmHWM')).split()[1])"
            "\nsys.exit(code)\n"
        )
        done = this_python("-c", code)
        assert done.returncode == 0, done.stderr
        peaks.append(float(done.stdout.split()[-1]) * 1024)
        assert {path.name for path in out.iterdir()} == {"summary.json", "result.vtkhdf", RECORD}
    few, many = (read_result(tmp_path / name / "result.vtkhdf") for name in ("few", "many"))
    assert (len(few.t), len(many.t)) == (50_001, 200_001)
    numbers = sum(
        array.nbytes for array in (many.q, many.v, many.multipliers, many.node_positions_G)
    )
    assert numbers > 40e6
    assert peaks[1] - peaks[0] < 8e6
    np.testing.assert_allclose(many.signals[0].values[::4], few.signals[0].values, atol=1e-8)
