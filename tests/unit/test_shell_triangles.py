"""Geometry of shell triangles: axes, sides, errors."""

import numpy as np
import pytest

from plymotion.preprocess.shell.shell_cells import ShellError
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles

POINTS = np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 1]])
X = np.array([1.0, 0, 0])
START, END = (0, 1, 2), (1, 2, 0)  # corners of the three sides


def test_axes_of_a_flat_triangle() -> None:
    t = triangles(POINTS, np.array([[0, 1, 2]]), np.array([1.0, 1.0, 5.0]))
    e1 = np.array([1.0, 1.0, 0]) / np.sqrt(2)
    assert np.allclose(t.A_GE[0], np.stack([e1, [-e1[1], e1[0], 0], [0, 0, 1]], axis=1))
    assert np.allclose(t.area, 1.0)
    assert np.allclose(t.length, [[2, np.sqrt(5), 1]])
    assert len(t) == 1


def test_flip_reverses_the_normal_and_keeps_the_reference_direction() -> None:
    cells = np.array([[0, 1, 2], [0, 1, 2]])
    t = triangles(POINTS, cells, X, np.array([False, True]))
    assert np.allclose(t.A_GE[:, :, 2], [[0, 0, 1], [0, 0, -1]])
    assert np.allclose(t.A_GE[:, :, 0], X)
    assert np.allclose(np.linalg.det(t.A_GE), 1.0)
    assert (t.area > 0).all()


def test_areas_and_sides_in_space() -> None:
    rng = np.random.default_rng(0)
    points, cells = rng.normal(size=(30, 3)), np.arange(30).reshape(10, 3)
    t = triangles(points, cells, rng.normal(size=(10, 3)), rng.random(10) > 0.5)
    assert np.allclose(t.A_GE @ t.A_GE.swapaxes(1, 2), np.eye(3))
    assert np.allclose(t.xy_E.mean(axis=1), 0.0)
    corners = points[cells]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.allclose(t.area, 0.5 * np.linalg.norm(normal, axis=1))
    sides = corners[:, END] - corners[:, START]
    assert np.allclose(t.length, np.linalg.norm(sides, axis=2))
    in_G = t.length[..., None] * t.tangent @ t.A_GE[:, :, :2].swapaxes(1, 2)
    assert np.allclose(in_G, sides)


def test_part_of_the_triangles() -> None:
    t = triangles(POINTS, np.array([[0, 1, 2], [0, 1, 3], [1, 2, 3]]), np.array([0.3, 0.2, 0.1]))
    assert np.array_equal(t[1:].xy_E, t.xy_E[1:])
    assert len(t[1:]) == 2


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_no_area_is_refused_at_any_size(size) -> None:
    points = size * np.vstack([POINTS, [4.0, 1e-12, 0]])
    with pytest.raises(ShellError, match=r"has no area: 1 \(nodes 0, 1, 4\), 2 \(nodes 1, 1, 2\)"):
        triangles(points, np.array([[0, 1, 2], [0, 1, 4], [1, 1, 2]]), X)


def test_direction_along_the_normal_is_refused() -> None:
    with pytest.raises(ShellError, match=r"normal to its reference direction: 0 \(nodes 0, 1, 2\)"):
        triangles(POINTS, np.array([[0, 1, 2], [0, 1, 3]]), np.array([0, 1e-9, 1.0]))


def test_many_faults_are_counted() -> None:
    with pytest.raises(ShellError, match=r"4 \(nodes 0, 0, 1\) and 3 more"):
        triangles(POINTS, np.array([[0, 0, 1]] * 8), X)


def test_unknown_position_is_refused() -> None:
    points = POINTS.copy()
    points[2] = np.nan
    with pytest.raises(ShellError, match="has no area: 0"):
        triangles(points, np.array([[0, 1, 2]]), X)
