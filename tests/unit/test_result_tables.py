"""Result files of many bodies, joints and signals: tables in place of a group for each."""

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.result_samples import crowd

from plymotion.solver.math.rows import StoredRows, temporary_file
from plymotion.solver.results import ResultError, read_result, write_result
from plymotion.solver.results.run_result import BodyView, Loads
from plymotion.solver.results.surfaces import all_positions, node_positions


def same(one: object, two: object) -> bool:
    if isinstance(one, BodyView):
        assert isinstance(two, BodyView)
        names = ("first_position", "shapes_B", "mass", "centre_B", "labels", "surface")
        return all(same(getattr(one, name), getattr(two, name)) for name in names)
    if dataclasses.is_dataclass(one):
        return all(
            same(getattr(one, f.name), getattr(two, f.name)) for f in dataclasses.fields(one)
        )
    if isinstance(one, tuple):
        assert isinstance(two, tuple)
        return len(one) == len(two) and all(map(same, one, two))
    return bool(np.array_equal(np.asarray(one), np.asarray(two)))


@pytest.mark.parametrize("count", [4, 5, 150])
def test_bodies_joints_and_signals_come_back(tmp_path: Path, count: int) -> None:
    random = np.random.default_rng(3)
    loads = Loads(("a", "b"), np.arange(5.0), random.random((5, 2, 3)), random.random((5, 2, 6)))
    path, result = tmp_path / "result.vtkhdf", dataclasses.replace(crowd(count), loads=loads)
    write_result(path, result)
    found = read_result(path)
    for name in ("bodies", "links", "signals", "loads"):
        assert same(getattr(result, name), getattr(found, name)), name
    assert found.provenance == result.provenance
    assert np.array_equal(found.node_positions_G, result.node_positions_G)
    with h5py.File(path) as file:
        version = file.attrs["format_version"].tolist()
        assert version == ([1, 5] if count == 4 else [2, 2])  # old readers refuse tables


def test_the_number_of_objects_does_not_grow_with_bodies_and_signals(tmp_path: Path) -> None:
    """Each object of HDF5 takes a millisecond to write, and as long for the checksum."""
    counts = []
    for count in (150, 3000):  # names of the latter are longer than an attribute
        write_result(tmp_path / "result.vtkhdf", crowd(count))
        with h5py.File(tmp_path / "result.vtkhdf") as file:
            seen: list[str] = []
            file.visit(seen.append)
        counts.append(len(seen))
    assert counts[0] == counts[1] < 150


def test_a_damaged_table_is_named(tmp_path: Path) -> None:
    path = tmp_path / "result.vtkhdf"
    write_result(path, crowd(150))
    with h5py.File(path, "r+") as file:
        del file["results/bodies_table/mass/values"]
    with pytest.raises(ResultError, match=r"/results/bodies_table: damaged table"):
        read_result(path)


def test_damaged_loads_are_named(tmp_path: Path) -> None:
    path, loads = tmp_path / "result.vtkhdf", Loads(("a",), np.zeros(1), *np.zeros((2, 1, 1, 6)))
    loads = dataclasses.replace(loads, place_G=np.zeros((1, 2, 3)))
    write_result(path, dataclasses.replace(crowd(3), loads=loads))
    with pytest.raises(ResultError, match=r"/results/loads: damaged view: expected places and"):
        read_result(path)


def test_nodes_of_many_bodies_are_those_of_each() -> None:
    random = np.random.default_rng(1)
    q = random.normal(size=(4, 7 * 40))
    bodies = [
        (7 * i, random.normal(size=(1 + i % 3, 3)), np.zeros((0, 1 + i % 3, 3))) for i in range(40)
    ]
    expected = np.concatenate([node_positions(q, *body) for body in bodies], axis=1)
    np.testing.assert_allclose(all_positions(q, bodies), expected, rtol=0.0, atol=1e-13)


def test_rows_share_a_file(tmp_path: Path) -> None:
    """A file for each signal would be more than a process may open."""
    file, numbers = temporary_file(tmp_path), np.arange(60.0).reshape(20, 3)
    one, two = StoredRows((3,), file), StoredRows((), file)
    for first, end in ((0, 7), (7, 8), (8, 20)):
        one.append(numbers[first:end])
        two.append(-numbers[first:end, 0])
    for key in (slice(None), slice(2, 15), slice(7, 8), 19, np.array([1, 6, 7, 8, 3])):
        assert np.array_equal(one[key], numbers[key])
        assert np.array_equal(two[key], -numbers[key, 0])
