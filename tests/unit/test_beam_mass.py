"""Mass of a beam: assembled, as stations, as the invariants of the solver."""

import numpy as np
import pytest
from samples.beam_samples import modal_mass, straight_line

from plymotion.preprocess.beam.beam_stations import (
    Stations,
    mass_stations,
    nodal_mass,
    point_masses,
)
from plymotion.preprocess.beam.line import BeamLine, SectionMass, section_axes
from plymotion.solver.math.rotations import skew
from plymotion.solver.package.body.invariants import inertia_at_rest
from plymotion.solver.package.common.cells import node_positions

FORMS = ("consistent", "lumped")
M_LINE, LENGTH = 2.0, 1.3
J = np.array([[5e-3, 0, 0], [0, 2e-3, 4e-4], [0, 4e-4, 3e-3]])
ECCENTRIC = SectionMass(M_LINE, np.array([0.0, 0.01, -0.02]), J)


def eccentric_line(elements: int = 8) -> BeamLine:
    """Coupled stiffness, mass centre off the line, rolled section, unequal elements."""
    A = np.random.default_rng(0).normal(size=(6, 6))
    scale = np.sqrt([1e4, 3e3, 2e3, 50.0, 80.0, 120.0])
    K = (A @ A.T + 6 * np.eye(6)) * np.outer(scale, scale)
    x = node_positions(LENGTH, elements, [0.3])
    return straight_line(x, K, ECCENTRIC.matrix(), section_axes(np.array([0.0, 0.6, 0.8])))


def rigid_columns(line: BeamLine) -> np.ndarray:
    """Nodal displacements of unit translations and rotations about the origin."""
    columns = np.zeros((line.n_node, 6, 6))
    columns[:, :3, :3] = columns[:, 3:, 3:] = np.eye(3)
    columns[:, :3, 3:] = [-skew(x) for x in line.nodes_B]
    return columns.reshape(-1, 6)


@pytest.mark.parametrize("form", FORMS)
def test_stations_carry_the_assembled_mass(form: str) -> None:
    line = eccentric_line()
    X = np.random.default_rng(1).normal(size=(6 * line.n_node, 5))
    assembled = X.T @ (line.mass_matrix(form) @ X)
    stations = mass_stations(line, X, form)
    assert np.abs(modal_mass(stations) - assembled).max() < 1e-12 * np.abs(assembled).max()
    rotary = np.einsum("kai,kab,kbj->ij", stations.psi_B, stations.J_B, stations.psi_B)
    T11 = np.einsum("aaij->ij", stations.invariants(form).T11_B)
    assert np.abs(T11 + rotary - assembled).max() < 1e-12 * np.abs(assembled).max()


@pytest.mark.parametrize("form", FORMS)
def test_rigid_motion_of_the_stations_is_that_of_the_body(form: str) -> None:
    line = eccentric_line(200 if form == "lumped" else 8)
    stations = mass_stations(line, rigid_columns(line), form)
    inv = stations.invariants(form)
    A, mass = line.A_BE[0], M_LINE * LENGTH
    c = A @ ECCENTRIC.centre_E
    centre = np.array([LENGTH / 2, 0, 0]) + c
    assert inv.mass == pytest.approx(mass, rel=1e-13)
    assert np.allclose(inv.S0_B, mass * centre, rtol=1e-12, atol=1e-14)
    # exact inertia of a uniform bar about the origin; lumping the mass at nodes misses h^2/12
    spread = LENGTH**3 / 3 * M_LINE
    x2 = np.array([[spread, 0, 0], [0, 0, 0], [0, 0, 0]])
    cross = mass * LENGTH / 2 * np.outer([1.0, 0, 0], c)
    T00 = x2 + cross + cross.T + mass * np.outer(c, c)
    inertia = np.trace(T00) * np.eye(3) - T00 + LENGTH * A @ J @ A.T
    tolerance = {"consistent": 1e-12, "lumped": 0.6 / 200**2}[form]
    assert np.abs(inertia_at_rest(inv) - inertia).max() < tolerance * np.abs(inertia).max()
    # the same by the rigid modes' own mass matrix
    M = modal_mass(stations)
    assert np.allclose(M[:3, :3], mass * np.eye(3), atol=1e-12)
    assert np.allclose(M[3:, 3:], inertia_at_rest(inv), atol=1e-12)
    assert np.allclose(M[3:, :3], skew(inv.S0_B), atol=1e-12)
    # columns of T01, S and J_psi for a rigid rotation: phi = w x x, psi = w
    assert np.allclose(inv.S_B[:, 3:], -skew(inv.S0_B), atol=1e-12)
    assert np.allclose(inv.J_psi_B[:, 3:], inv.J0_B, atol=1e-15)


@pytest.mark.parametrize(
    ("J", "count"),
    [
        (np.zeros((3, 3)), 1),
        (np.diag([2e-3, 0.0, 2e-3]), 2),
        (J, 4),
        (np.diag([5e-3, 4e-3, 3e-3]), 6),
    ],
)
def test_points_have_mass_centre_and_inertia_of_their_slice(J: np.ndarray, count: int) -> None:
    m, x = np.array([2.0]), np.array([[0.3, 0.1, -0.2]])
    phi, psi = np.random.default_rng(1).normal(size=(2, 1, 3, 5))
    points = point_masses(Stations(m, x, phi, psi, J[None]))
    assert len(points.m) == count
    assert np.all(points.m > 0.0)
    assert points.m.sum() == pytest.approx(2.0, rel=1e-15)
    assert np.allclose(points.m @ points.s_B, 0.0, atol=1e-17)
    assert np.allclose(points.x_B, x + points.s_B, atol=1e-15)
    E = np.einsum("p,pa,pb->ab", points.m, points.s_B, points.s_B)
    assert np.allclose(np.trace(E) * np.eye(3) - E, J, atol=1e-17)
    # a point moves like the slice: centre and rotation
    moved = phi[0][None] + np.cross(psi[0][None], points.s_B[:, :, None], axis=1)
    assert np.allclose(points.phi_B, moved, atol=1e-16)


def test_inertia_of_no_mass_is_refused() -> None:
    slice_ = SectionMass(1.0, np.array([0.0, 0.1, 0.0]), np.diag([6e-3, 2e-3, 3e-3]))
    with pytest.raises(ValueError, match=r"impossible: 0\.002, 0\.003, 0\.006.*above the sum"):
        SectionMass.from_matrix(slice_.matrix())


@pytest.mark.parametrize("form", FORMS)
def test_points_have_the_inertia_and_momenta_of_the_slices(form: str) -> None:
    line = eccentric_line()
    X = np.random.default_rng(1).normal(size=(6 * line.n_node, 5))
    stations = mass_stations(line, X, form)
    slices, points = stations.invariants(form), point_masses(stations).invariants(form)
    assert np.abs(points.J0_B).max() == np.abs(points.J_psi_B).max() == 0.0
    assert np.allclose(inertia_at_rest(points), inertia_at_rest(slices), rtol=1e-13)
    T = points.T01_B - slices.T01_B
    moment = np.array([T[1, 2] - T[2, 1], T[2, 0] - T[0, 2], T[0, 1] - T[1, 0]])
    assert np.allclose(moment, slices.J_psi_B, atol=1e-14)
    assert np.allclose(points.S_B, slices.S_B, atol=1e-13)
    modal = np.einsum("aaij->ij", points.T11_B)
    assert np.allclose(modal, modal_mass(stations), rtol=1e-12, atol=1e-14)


def test_nodal_mass_is_the_diagonal_of_the_lumped_mass() -> None:
    line = eccentric_line()
    mass, inertia = nodal_mass(line)
    blocks = line.mass_matrix("lumped").toarray().reshape(line.n_node, 6, line.n_node, 6)
    for k in range(line.n_node):
        assert np.allclose(blocks[k, :3, k, :3], mass[k] * np.eye(3), atol=1e-15)
        assert np.allclose(blocks[k, 3:, k, 3:], inertia[k], atol=1e-15)
    assert mass.sum() == pytest.approx(M_LINE * LENGTH, rel=1e-13)


@pytest.mark.parametrize("form", FORMS)
def test_participation_splits_the_modal_mass(form: str) -> None:
    line = eccentric_line()
    X = np.random.default_rng(2).normal(size=(6 * line.n_node, 3))
    stations = mass_stations(line, X, form)
    products = stations.J_B.copy()
    products[:, range(3), range(3)] = 0.0
    missing = np.einsum("kai,kab,kbj->ij", stations.psi_B, products, stations.psi_B)
    assert np.allclose(stations.participation().sum(axis=0) + missing, modal_mass(stations))


def test_mass_that_is_no_rigid_slice_is_refused() -> None:
    assert np.allclose(
        SectionMass.from_matrix(ECCENTRIC.matrix()).centre_E, ECCENTRIC.centre_E, atol=1e-15
    )
    matrix = ECCENTRIC.matrix()
    matrix[0, 1] = matrix[1, 0] = 0.1
    with pytest.raises(ValueError, match=r"entry \[0, 1\]"):
        SectionMass.from_matrix(matrix)
    with pytest.raises(ValueError, match="positive"):
        SectionMass.from_matrix(np.zeros((6, 6)))


@pytest.mark.parametrize("noise", [1e-18, -1e-18])
def test_strip_without_rotary_inertia_about_one_axis(noise: float) -> None:
    """Rounding beside a zero of the diagonal is no fault; a static moment there is one."""
    mass = np.diag([1.0, 1.0, 1.0, 2e-3, 0.0, 2e-3])
    mass[0, 4] = noise
    assert SectionMass.from_matrix(mass).m == 1.0
    mass[0, 4] = 1e-6
    with pytest.raises(ValueError, match=r"not that of a rigid slice: entry \[0, 4\]"):
        SectionMass.from_matrix(mass)
