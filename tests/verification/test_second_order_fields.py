"""Second-order displacements of beams against exact kinematics and geometric stiffness."""

import dataclasses

import numpy as np
import pytest
from samples.beam_samples import (
    CHORD,
    CLAMPED,
    MEAN_AXIS,
    NAMES,
    REFERENCES,
    coupled_stiffness,
    reduced,
)

from plymotion.preprocess.beam.beam_body import held_dofs
from plymotion.preprocess.beam.beam_stations import mass_stations, nodal_mass, point_masses
from plymotion.preprocess.beam.element import Z, gauss
from plymotion.preprocess.beam.line import SectionMass
from plymotion.preprocess.beam.mode_fields import second_order_fields
from plymotion.solver.math.rotations import matrix_to_vector, vector_to_matrix
from plymotion.solver.package.body.invariants import rigid_motions

SIX = [{"kind": "lowest", "count": 6}]


def bent(reference, **changes):
    return reduced(reference, SIX, K=coupled_stiffness(), **changes)


def exact_tip(beam, q, steps=300):
    """Place and rotation vector of the tip when the modes are strains of an exact beam."""
    line = beam.model.line
    element = line.spans[0].element
    nodal = line.to_element(beam.modes.columns_B @ q[:, None])[..., 0]
    step = element.length / steps
    strains = element.strain((np.arange(steps) + 0.5) * step)
    r, R = np.zeros(3), np.eye(3)
    for values in nodal:
        for strain in strains @ values:
            half = vector_to_matrix(0.5 * step * strain[3:])
            r = r + step * R @ half @ (np.array([1.0, 0.0, 0.0]) + strain[:3])
            R = R @ half @ half
    return r, matrix_to_vector(R)


def test_tip_follows_the_exact_beam_to_second_order():
    """Bending in two planes, twist, shear and extension coupled: the error falls eightfold."""
    beam = bent(CLAMPED, elements=4)
    tip = beam.interface("tip")
    direction = np.random.default_rng(1).normal(size=6)
    errors, linear = [], []
    for size in (4e-3, 2e-3):
        q = size * direction
        r, turn = exact_tip(beam, q)
        one = np.concatenate([tip.position_B + tip.phi_B @ q, tip.psi_B @ q])
        H = np.concatenate([tip.H_B, tip.H_psi_B])
        two = one + 0.5 * np.einsum("aij,i,j->a", H, q, q)
        exact = np.concatenate([r, turn])
        linear.append(np.abs(exact - one).reshape(2, 3).max(axis=1))
        errors.append(np.abs(exact - two).reshape(2, 3).max(axis=1))
    assert (np.array(errors[0]) < 0.05 * np.array(linear[0])).all()
    np.testing.assert_allclose(np.log2(np.array(errors[0]) / errors[1]), 3.0, atol=0.1)


def geometric_stiffness(line, load_B, n_point=6):
    """K_geo of a clamped beam under nodal loads (6 n,), assembled from its resultants.

    int N_i' (F . strain_2) N_j with the second-order strains of an exact beam and those of twist,
    integrated in each element by a rule of its own.
    """
    K = line.stiffness().toarray()
    free = np.arange(6, len(K))
    u = np.zeros(len(K))
    u[free] = np.linalg.solve(K[np.ix_(free, free)], load_B[free])
    nodal = line.to_element(u[:, None])[..., 0]
    G = np.zeros_like(K)
    for span in line.spans:
        element, numbers, K_section = span.element, span.numbers, span.section.K
        turn = np.kron(np.eye(4), line.A_BE[numbers[0]])
        x, weights = gauss(element.length, n_point)
        shape, strain = element.shape(x), element.strain(x)
        slope = strain + Z @ shape
        for number in numbers:
            Ge = np.zeros((12, 12))
            for N, N_x, B, weight in zip(shape, slope, strain, weights, strict=True):
                F = K_section @ B @ nodal[number]
                f, u_x, f_x = N[3:], N_x[:3], N_x[3:]
                e1 = np.array([1.0, 0.0, 0.0])
                for i in range(12):
                    for j in range(12):
                        part = -np.cross(f[:, i], u_x[:, j])
                        part = part + 0.5 * np.cross(f[:, i], np.cross(f[:, j], e1))
                        value = F[:3] @ part - 0.5 * F[3:] @ np.cross(f[:, i], f_x[:, j])
                        value += 0.5 * F @ span.section.trapeze * B[3, i] * B[3, j]
                        Ge[i, j] += weight * value
            Ge = turn @ (Ge + Ge.T) @ turn.T
            dofs = 6 * number + np.arange(12)
            G[np.ix_(dofs, dofs)] += Ge
    return G


@pytest.mark.parametrize("seed", [0, 1])
def test_reciprocity_with_the_geometric_stiffness_of_random_loads(seed):
    """sum f_k . h_ij,k = - X_i' K_geo(f) X_j: two routes to one number, moments included."""
    beam = bent(CLAMPED, x2_axis=[0.0, 0.8, 0.6], elements=2)
    trapeze = 1e-2 * np.random.default_rng(9).normal(size=6)
    line, X = beam.model.line, beam.modes.columns_B
    section = dataclasses.replace(line.sections[0], trapeze=trapeze)
    line = dataclasses.replace(line, sections=(section,))
    points = point_masses(mass_stations(line, X, "consistent"))
    fields = second_order_fields(line, X, points, "consistent", held_dofs("clamped", (0,)))
    load = np.random.default_rng(seed).normal(size=6 * line.n_node)
    load[:6] = 0.0
    nodal = np.concatenate([fields.node_u_B, fields.node_f_B], axis=1).reshape(len(load), 6, 6)
    work = np.einsum("n,nij->ij", load, nodal)
    expected = -X.T @ geometric_stiffness(line, load) @ X
    np.testing.assert_allclose(work, expected, atol=1e-11 * np.abs(expected).max())


def test_slender_bending_is_drawn_in_by_half_the_square_of_its_slope():
    K = np.diag([1e9, 1e9, 1e9, 20.0, 30.0, 25.0])
    mass = SectionMass(1.0, np.zeros(3), 1e-9 * np.eye(3)).matrix()
    modes = [{"kind": f"bending-x{axis}", "count": 2} for axis in "yz"]
    beam = reduced(CLAMPED, modes, K=K, mass=mass, elements=12)
    element = beam.model.line.spans[0].element
    x, weights = gauss(element.length, 4)
    nodal = beam.model.line.to_element(beam.modes.columns_B)
    slope = (element.strain(x) + Z @ element.shape(x)) @ nodal[:, None]
    along = slope[:, :, 1:3]
    expected = -np.einsum("g,egai,egaj->ij", weights, along, along)
    np.testing.assert_allclose(beam.interface("tip").H_B[0], expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_frames_see_fields_that_fulfil_their_condition(reference, mass_form):
    beam = bent(reference, mass_form=mass_form)
    second = beam.package.second_order
    root, tip = beam.interface("root"), beam.interface("tip")
    size = np.abs(tip.H_B).max() + np.abs(tip.H_psi_B).max()
    if reference is CLAMPED:
        assert np.abs(root.H_B).max() == np.abs(root.H_psi_B).max() == 0.0
    elif reference is CHORD:
        held = [*root.H_B, root.H_psi_B[0], *tip.H_B[1:]]
        assert np.abs(held).max() < 1e-12 * size
    else:
        assert np.abs(second.Z0_B).max() < 1e-12 * size
    for table in (second.Z0_B, second.Z1_B, second.G3, second.G4, tip.H_B, tip.H_psi_B):
        np.testing.assert_allclose(table, np.swapaxes(table, -1, -2), atol=1e-12 * size)


def test_frames_differ_by_a_rigid_motion_only():
    """One shape in two frames: its second-order fields differ by a rigid motion of second order."""
    clamped = bent(CLAMPED)
    line = clamped.model.line
    X = clamped.modes.columns_B
    points = point_masses(mass_stations(line, X, "consistent"))
    fields = [
        second_order_fields(line, X, points, "consistent", held)
        for held in (held_dofs("clamped", (0,)), held_dofs("chord", (0, line.n_node - 1)), None)
    ]
    rigid = rigid_motions(points.x_B)[:, :3].reshape(-1, 6)
    for other in fields[1:]:
        gap = (other.h_B - fields[0].h_B).reshape(len(rigid), -1)
        left = gap - rigid @ np.linalg.lstsq(rigid, gap, rcond=None)[0]
        assert np.abs(left).max() < 1e-12 * np.abs(gap).max()


def test_points_turn_with_their_sections():
    """A point of a section stands at r + R s: here a twisted bar with its mass centre across."""
    twist = [{"kind": "torsion", "count": 1}]
    mass = SectionMass(1.0, np.array([0.0, 0.0, 0.02]), np.diag([0.03, 0.018, 0.012])).matrix()
    beam = reduced(CLAMPED, twist, mass=mass, mass_form="lumped")
    X, line = beam.modes.columns_B, beam.model.line
    stations = mass_stations(line, X, "lumped")
    points = point_masses(stations)
    assert len(points.m) == 4 * len(stations.m)
    fields = second_order_fields(line, X, points, "lumped", held_dofs("clamped", (0,)))
    nodal = X.reshape(line.n_node, 6, 1)
    # both ends of each element in turn
    for p, k in enumerate((points.slice_of + 1) // 2):
        s = points.x_B[p] - line.nodes_B[k]
        f = nodal[k, 3:, 0]
        expected = fields.node_u_B[k, :, 0, 0] + np.cross(fields.node_f_B[k, :, 0, 0], s)
        expected = expected + np.cross(f, np.cross(f, s))
        np.testing.assert_allclose(fields.h_B[p, :, 0, 0], expected, atol=1e-13)
    assert np.abs(fields.h_B).max() > 1e-3


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
def test_mean_axis_has_no_antisymmetric_moment(mass_form):
    """Rotary inertia included: the frame follows the points themselves."""
    Z1 = bent(MEAN_AXIS, mass_form=mass_form).package.second_order.Z1_B
    assert np.abs(Z1 - Z1.swapaxes(0, 1)).max() < 1e-12 * np.abs(Z1).max()


@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_inertia_of_the_bent_body_is_that_of_turned_slices(reference):
    """Of sections with an offset centre and a product of inertia; the error is of third order."""
    J = np.array([[0.03, 0.0, 0.0], [0.0, 0.018, 0.004], [0.0, 0.004, 0.012]])
    slice_ = SectionMass(1.0, np.array([0.0, 0.02, -0.01]), J)
    beam = bent(reference, mass=slice_.matrix(), mass_form="lumped", x2_axis=[0.0, 0.8, 0.6])
    line, package = beam.model.line, beam.package
    X = beam.modes.columns_B.reshape(line.n_node, 6, -1)
    points = point_masses(mass_stations(line, beam.modes.columns_B, "lumped"))
    held = held_dofs(reference["kind"], beam.model.reference_nodes)
    fields = second_order_fields(line, beam.modes.columns_B, points, "lumped", held)
    mass, _ = nodal_mass(line)
    inv, two = package.invariants, package.second_order
    errors = []
    for size in (1e-3, 5e-4):
        q = size * np.random.default_rng(3).normal(size=6)
        exact = np.zeros((3, 3))
        for k, m in enumerate(mass):
            R = vector_to_matrix(X[k, 3:] @ q + 0.5 * fields.node_f_B[k] @ q @ q) @ line.A_BE[0]
            c = line.nodes_B[k] + X[k, :3] @ q + 0.5 * fields.node_u_B[k] @ q @ q
            c = c + R @ slice_.centre_E
            exact += m * R @ (0.5 * np.trace(J) * np.eye(3) - J) @ R.T + m * np.outer(c, c)
        first = inv.T01_B @ q + 0.5 * two.Z1_B @ q @ q
        found = inv.T00_B + inv.J0_B + first + first.T + inv.T11_B @ q @ q
        errors.append(np.abs(found - exact).max())
        assert errors[-1] < 0.2 * np.abs(first).max()
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3.0, abs=0.1)
