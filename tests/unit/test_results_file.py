"""The result file and the summary: what is written comes back, bad files are named."""

import dataclasses
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.package_samples import same
from samples.result_samples import swinging_rod

from plymotion.solver.package.common.files import RECORD
from plymotion.solver.results import (
    ResultError,
    RunResult,
    Signal,
    read_result,
    read_summary,
    signal_summary,
    write_result,
    write_summary,
)
from plymotion.solver.results.summary import MEASURES


def equal(a: RunResult, b: RunResult) -> bool:
    for name in ("energies", "violations"):
        left, right = getattr(a, name), getattr(b, name)
        if set(left) != set(right) or not all(np.array_equal(left[k], right[k]) for k in left):
            return False
    plain = {"energies": {}, "violations": {}}
    return same(dataclasses.replace(a, **plain), dataclasses.replace(b, **plain))


def test_the_sample_keeps_its_energy() -> None:
    """The sample is physics, not noise: its balance closes."""
    result = swinging_rod()
    assert np.abs(result.energy_balance).max() < 1e-8 * np.ptp(result.energies["kinetic"])


def test_round_trip_keeps_every_field(tmp_path: Path) -> None:
    result = swinging_rod()
    write_result(tmp_path / "result.vtkhdf", result)
    assert equal(result, read_result(tmp_path / "result.vtkhdf"))


def test_round_trip_of_one_instant_and_of_large_arrays(tmp_path: Path) -> None:
    path = tmp_path / "result.vtkhdf"
    one = swinging_rod()
    cut = {
        name: getattr(one, name)[:1] for name in ("t", "q", "v", "multipliers", "node_positions_G")
    }
    one = dataclasses.replace(
        one,
        **cut,
        signals=tuple(dataclasses.replace(s, values=s.values[:1]) for s in one.signals),
        energies={k: v[:1] for k, v in one.energies.items()},
        violations={},
    )
    long = dataclasses.replace(swinging_rod(k=6001), node_deflection=np.ones((6001, 10)))
    for result in (one, long):
        write_result(path, result)
        assert equal(result, read_result(path))


def test_every_dataset_of_results_says_unit_frame_and_meaning(tmp_path: Path) -> None:
    write_result(tmp_path / "result.vtkhdf", swinging_rod())
    with h5py.File(tmp_path / "result.vtkhdf") as h5:
        seen: list[set[str]] = []
        h5["results"].visititems(
            lambda _, d: seen.append(set(d.attrs)) if isinstance(d, h5py.Dataset) else None
        )
    assert len(seen) > 15
    assert all({"unit", "frame", "description"} <= attributes for attributes in seen)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"t": np.zeros(501)}, "t: expected at least one time, in ascending order"),
        ({"q": np.zeros((3, 7))}, "q: expected shape (501, 7), got (3, 7)"),
        ({"energies": {"kinetic": np.zeros(501)}}, "energies/strain: missing"),
        ({"node_positions_G": np.zeros((501, 4, 3))}, "expected shape (501, 10, 3)"),
        ({"violations": {"position": np.zeros(2)}}, "violations/position"),
    ],
)
def test_writer_refuses_sizes_that_disagree(
    tmp_path: Path, change: dict[str, object], words: str
) -> None:
    with pytest.raises(ResultError) as caught:
        write_result(tmp_path / "result.vtkhdf", dataclasses.replace(swinging_rod(), **change))
    assert words in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_reader_names_what_is_wrong(tmp_path: Path) -> None:
    path = tmp_path / "result.vtkhdf"
    with pytest.raises(ResultError, match="no such file"):
        read_result(path)
    write_result(path, swinging_rod())
    raw = path.read_bytes()
    path.write_bytes(raw[: len(raw) // 2])
    with pytest.raises(ResultError, match="truncated"):
        read_result(path)
    path.write_bytes(raw)
    with h5py.File(path, "r+") as h5:
        h5.move("results/multipliers", "results/multiplier")
    with pytest.raises(ResultError, match="no 'multipliers'; did you mean 'multiplier'"):
        read_result(path)
    path.write_bytes(raw)
    with h5py.File(path, "r+") as h5:
        h5.attrs["format_version"] = [3, 1]
    with pytest.raises(ResultError, match=r"newer Plymotion: format 3\.1, this reader knows 1\.x"):
        read_result(path)
    with h5py.File(path, "w") as h5:
        h5.create_group("Mesh")
    with pytest.raises(ResultError, match="XDMF"):
        read_result(path)


def test_signal_summary_against_a_parabola() -> None:
    t = np.linspace(0.0, 2.0, 201)
    found = signal_summary(Signal("s", "m", "", 3.0 - (t - 0.5) ** 2), t)
    assert found["unit"] == "m"
    assert found["max"] == pytest.approx(3.0, abs=1e-12)
    assert found["t_max"] == pytest.approx(0.5, abs=1e-12)
    assert found["min"] == found["final"] == pytest.approx(0.75, abs=1e-12)
    assert found["t_min"] == 2.0


def test_signal_summary_passes_over_nan() -> None:
    t = np.arange(4.0)
    found = signal_summary(Signal("s", "m", "", np.array([1.0, np.nan, 5.0, np.nan])), t)
    assert (found["min"], found["max"], found["t_max"], found["final"]) == (1.0, 5.0, 2.0, None)
    empty = signal_summary(Signal("s", "m", "", np.full(4, np.nan)), t)
    assert empty == {"unit": "m"} | dict.fromkeys(MEASURES)


def test_summary_is_json_without_nan(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    wild = {"run": "a", "x": np.float64("nan"), "y": [np.int64(3), float("inf")], "z": np.arange(2)}
    write_summary(path, wild)

    def refuse(name: str) -> None:
        raise AssertionError(name)

    expected = {"run": "a", "x": None, "y": [3, None], "z": [0, 1]}
    assert json.loads(path.read_text(), parse_constant=refuse) == expected
    assert read_summary(path) == expected
    assert {file.name for file in tmp_path.iterdir()} == {path.name, RECORD}


def test_summary_that_is_no_json_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    write_summary(path, {"run": "old"})
    with pytest.raises(ResultError, match="not JSON"):
        write_summary(path, {"run": object()})
    assert read_summary(path) == {"run": "old"}


@pytest.mark.parametrize("text", ["", "{", "[1]", "{}"])
def test_bad_summary_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "summary.json"
    path.write_text(text)
    with pytest.raises(ResultError, match=r"summary\.json"):
        read_summary(path)
