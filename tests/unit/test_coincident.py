"""Pairs of nodes at the same position, against the distances of all pairs."""

import numpy as np
import pytest

from plymotion.preprocess.mesh_input import coincident


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("distance", [1e-7, 0.3])
def test_pairs_are_those_of_all_distances(dimension: int, distance: float) -> None:
    random = np.random.default_rng(1)
    points = random.random((60, dimension))
    shift = 0.9e-7 / np.sqrt(dimension)
    points = np.concatenate([points, points[::7] + shift, points[::11] - 3.0 * shift, points[:2]])
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    expected = np.argwhere(np.triu(apart <= distance, 1))
    assert len(expected) > 5
    assert np.array_equal(coincident(points, distance), expected)


def test_a_grid_has_no_pair_and_a_slit_has_its_nodes() -> None:
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 41), np.linspace(0.0, 0.5, 21))
    grid = np.stack([x.ravel(), y.ravel()], axis=1)
    assert coincident(grid, 1e-7).shape == (0, 2)
    slit = np.flatnonzero(grid[:, 1] == 0.25)
    pairs = coincident(np.concatenate([grid, grid[slit]]), 1e-7)
    assert np.array_equal(pairs, np.stack([slit, len(grid) + np.arange(len(slit))], axis=1))


def test_few_points() -> None:
    assert coincident(np.zeros((0, 3)), 1.0).shape == (0, 2)
    assert coincident(np.zeros((1, 3)), 1.0).shape == (0, 2)
    assert coincident(np.zeros((3, 2)), 0.0).tolist() == [[0, 1], [0, 2], [1, 2]]
