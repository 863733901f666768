"""Boxes that stand for rigid bodies in pictures."""

import numpy as np
import pytest

from plymotion.solver.dynamics.elements.joints.contract import FREEDOMS
from plymotion.solver.dynamics.elements.joints.table import JOINTS
from plymotion.solver.math.rotations import vector_to_matrix
from plymotion.solver.report.scene import glyph
from plymotion.solver.results.surfaces import rigid_surface, uniform_box, with_spheres

EDGES = np.array([0.3, 0.5, 1.2])  # m
MASS = 7.0


def inertia(edges: np.ndarray, A: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First moment and inertia about the origin of a uniform box, by its closed form."""
    moments = MASS / 12.0 * (np.sum(edges**2) - edges**2)
    about_centre = A @ np.diag(moments) @ A.T
    return MASS * c, about_centre + MASS * (c @ c * np.eye(3) - np.outer(c, c))


@pytest.mark.parametrize("turn", [[0.0, 0.0, 0.0], [0.4, -0.9, 0.3]])
def test_a_box_is_found_from_its_inertia(turn: list[float]) -> None:
    A, c = vector_to_matrix(np.array(turn)), np.array([0.2, -0.1, 0.7])
    edges, axes = uniform_box(MASS, *inertia(EDGES, A, c))
    np.testing.assert_allclose(np.sort(edges), EDGES, rtol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(
        axes @ np.diag(edges**2) @ axes.T, A @ np.diag(EDGES**2) @ A.T, atol=1e-12
    )


def test_the_surface_is_that_box_and_bars() -> None:
    A, c = vector_to_matrix(np.array([0.4, -0.9, 0.3])), np.array([0.2, -0.1, 0.7])
    nodes = np.array([[0.05, 0.0, 0.0], [1.0, 0.0, 0.0]])
    surface = rigid_surface(nodes, c, EDGES, A, width=0.01, reach=10.0)
    corners = (nodes[surface.node] + surface.offset_B)[:8]
    np.testing.assert_allclose(np.sort(np.abs((corners - c) @ A), axis=0)[0], 0.5 * EDGES)
    # Outward faces: the volume by the divergence theorem.
    p = corners[surface.triangles[:12]]
    volume = np.einsum("fa,fa->", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6.0
    assert volume == pytest.approx(np.prod(EDGES))
    assert len(surface.triangles) == 12 + 12  # and one bar


def test_bodies_without_a_size_of_their_own_are_small_cubes() -> None:
    for mass, S, J in ((0.0, np.zeros(3), np.zeros((3, 3))), (2.0, np.ones(3), np.zeros((3, 3)))):
        edges, axes = uniform_box(mass, S, J)
        np.testing.assert_array_equal(edges, 0.0)
        surface = rigid_surface(np.zeros((1, 3)), np.zeros(3), edges, axes, width=0.1, reach=1.0)
        assert np.ptp(surface.offset_B @ axes, axis=0) == pytest.approx([0.13] * 3)


def test_a_flywheel_does_not_fill_the_picture() -> None:
    edges, axes = uniform_box(1.0, np.zeros(3), np.diag([50.0, 50.0, 90.0]))
    surface = rigid_surface(np.zeros((1, 3)), np.zeros(3), edges, axes, width=0.01, reach=1.0)
    assert np.ptp(surface.offset_B @ axes, axis=0).max() == pytest.approx(1.2)


def test_point_masses_are_spheres_about_their_places() -> None:
    nodes = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    bare = rigid_surface(nodes, np.zeros(3), np.full(3, 0.2), np.eye(3), 0.02, 1.0)
    place, n = np.array([1.0, 0.1, 0.0]), len(bare.node)
    drawn = with_spheres(bare, nodes, [(place, 1.0), (nodes[0], 1e9)], 2.0)
    points = nodes[drawn.node] + drawn.offset_B
    np.testing.assert_array_equal(points[:n], nodes[bare.node] + bare.offset_B)
    one, two = np.split(points[n:], 2)
    of_steel = (3.0 / (4.0 * np.pi * 7850.0)) ** (1.0 / 3.0)
    np.testing.assert_allclose(np.linalg.norm(one - place, axis=1), of_steel, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(two, axis=1), 0.1, rtol=1e-12)  # not larger
    a, b, c = (points[drawn.triangles[len(bare.triangles) :, k]] for k in range(3))
    outward = np.cross(b - a, c - a)
    middle = (a + b + c) / 3.0
    centre = np.where(middle[:, :1] > 0.5, place, nodes[0])
    assert np.einsum("fa,fa->f", outward, middle - centre).min() > -1e-15
    volume = np.einsum("fa,fa->f", outward, a - centre).sum() / 6.0
    spheres = 4.0 / 3.0 * np.pi * (of_steel**3 + 0.1**3)
    assert 0.8 * spheres < volume < spheres


def volume(free: tuple[str, ...]) -> float:
    """Of the symbol of a joint, by the divergence theorem [m3]: positive if triangles face out."""
    points, faces = glyph(free, 1.0)
    one, two, three = (points[faces[:, k]] for k in range(3))
    return float(np.einsum("ni,ni->", one, np.cross(two, three)) / 6.0)


def test_symbols_of_joints_differ() -> None:
    """Closed surfaces, one for each set of freedoms, but all balls are one."""
    frees = {
        tuple(free for free in FREEDOMS if free not in joint.removes) for joint in JOINTS.values()
    }
    volumes = {free: volume(free) for free in frees}
    assert volumes.pop(()) == 0.0
    balls = {f for f in frees if f and sum(each in "xyz" for each in f) in (0, 3) and len(f) > 1}
    assert len({round(volumes.pop(free), 6) for free in balls}) == 1
    assert min(volumes.values()) > 0.0
    assert len({round(each, 6) for each in volumes.values()}) == len(volumes)
