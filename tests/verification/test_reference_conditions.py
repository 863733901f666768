"""One body seen from three frames: the coordinates differ, the physics does not."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg
from samples.beam_samples import (
    CENTRE,
    CHORD,
    CLAMPED,
    MEAN_AXIS,
    NAMES,
    REFERENCES,
    ROTARY,
    Beam,
    coupled_stiffness,
    modal_mass,
    reduced,
    with_all_modes,
)
from samples.flexible_samples import momenta, simulate, total_energy

from plymotion.preprocess.beam.beam_stations import mass_stations
from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.checks.statics import missing_compliance
from plymotion.solver.dynamics.evaluation.accelerations import assemble
from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.math.rotations import rotation_matrix, skew
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import flexible_body
from plymotion.solver.package.body.invariants import free_body_mass, rigid_motions

EVERYWHERE = [{"kind": "attachment", "at": name} for name in ("root", "mid", "tip")]
by_reference = pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)


def free_model(beam: Beam) -> Model:
    return assemble_model([flexible_body("beam", beam.package)], [], [])


def at_rest(model: Model) -> np.ndarray:
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3] = 1.0
    return y


def squared_frequencies(K: np.ndarray, M: np.ndarray) -> np.ndarray:
    """Eigenvalues of a free pencil, those below the middle by its inverse: all to round-off."""
    high = scipy.linalg.eigh(K, M, eigvals_only=True)
    shift = np.sqrt(high[-1] * high[6])
    low = 1.0 / scipy.linalg.eigh(M, K + 1e-3 * high[6] * M, eigvals_only=True)[::-1]
    return np.where(high < shift, low - 1e-3 * high[6], high)


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@by_reference
def test_free_frequencies_of_the_linearised_motion(
    reference: dict[str, Any], mass_form: str
) -> None:
    """Equations of motion of the solver at rest, against the eigenvalues of the FE model."""
    beam = with_all_modes(reference, K=coupled_stiffness(), mass_form=mass_form)
    model, n = free_model(beam), beam.package.n_mode
    y = at_rest(model)
    stiffness = np.zeros((model.n_vel, model.n_vel))
    for k in range(n):  # at rest the forces are linear in the modal coordinates
        moved = y.copy()
        moved[7 + k] = 1.0
        stiffness[:, 6 + k] = -assemble(model, 0.0, moved).f
    assert np.abs(stiffness[:6]).max() == 0.0
    found = squared_frequencies(stiffness, assemble(model, 0.0, y).M)
    line = beam.model.line
    expected = squared_frequencies(
        line.stiffness().toarray(), line.mass_matrix(mass_form).toarray()
    )
    assert n == 24
    assert np.abs(found[:6]).max() < 1e-9 * expected[6]
    assert np.abs(found[6:] / expected[6:] - 1.0).max() < 1e-8


@by_reference
def test_package_knows_and_keeps_its_reference_condition(reference: dict[str, Any]) -> None:
    beam = reduced(
        reference, [{"kind": "lowest", "count": 5}, *EVERYWHERE, {"kind": "static-axial"}]
    )
    package = beam.package
    assert package.reference_condition == reference["kind"]
    root, tip = (np.vstack([i.phi_B, i.psi_B]) for i in map(beam.interface, ("root", "tip")))
    momentum = free_body_mass(package)[:6, 6:]
    if reference is CLAMPED:
        assert np.abs(root).max() == 0.0
    if reference is CHORD:
        assert np.abs(root[:4]).max() == 0.0
        assert np.abs(tip[1:3]).max() == 0.0
        assert np.abs(root[4:]).max() > 0.1
    if reference is MEAN_AXIS:
        assert np.abs(momentum).max() < 1e-12 * np.abs(package.invariants.T11_B).max()
        assert np.abs(root).max() > 0.1
    else:
        assert np.abs(momentum).max() > 0.01
    assert np.abs(package.mass - np.eye(package.n_mode)).max() == 0.0


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
def test_a_mean_axis_with_places_has_the_static_shapes_of_the_chord(mass_form: str) -> None:
    """Loads at the ends, in equilibrium, and a distributed one: the same energy, no momentum."""
    energies = []
    for reference in (CHORD, {**CHORD, "kind": "mean-axis"}):
        beam = reduced(reference, [{"kind": "attachment", "at": "tip"}, {"kind": "static-axial"}],
                       K=coupled_stiffness(), mass_form=mass_form)  # fmt: skip
        root, tip = (np.vstack([i.phi_B, i.psi_B]) for i in map(beam.interface, ("root", "tip")))
        carried = rigid_motions(beam.model.line.nodes_B[[-1]])[0].T  # of the tip, to the root
        work = tip.T - root.T @ carried
        energies.append(work.T @ (work / np.diag(beam.package.stiffness)[:, None]))
    momentum = free_body_mass(beam.package)[:6, 6:]
    assert np.abs(momentum).max() < 1e-12 * np.abs(beam.package.invariants.T11_B).max()
    np.testing.assert_allclose(energies[1], energies[0], atol=1e-10 * np.abs(energies[0]).max())


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@by_reference
def test_invariants_hold_the_mass_of_frame_and_all_modes(
    reference: dict[str, Any], mass_form: str
) -> None:
    """Sums over mass stations, static modes included, against R' M R, R' M X and X' M X."""
    asked = [{"kind": "lowest", "count": 4}, *EVERYWHERE, {"kind": "static-axial"}]
    beam = reduced(reference, asked, K=coupled_stiffness(), mass_form=mass_form)
    line = beam.model.line
    rigid = rigid_motions(line.nodes_B).reshape(6 * line.n_node, 6)
    columns = np.hstack([rigid, beam.modes.columns_B])
    M = columns.T @ (line.mass_matrix(mass_form) @ columns)
    found = free_body_mass(beam.package)
    assert np.abs(found - M).max() < 1e-11 * np.abs(M).max()
    stations = mass_stations(line, beam.modes.columns_B, mass_form)
    assert np.abs(modal_mass(stations) - np.eye(beam.package.n_mode)).max() < 1e-10


@pytest.mark.parametrize("reference", [*REFERENCES, {**CHORD, "kind": "mean-axis"}])
def test_all_modes_miss_nothing_of_the_compliance(reference: dict[str, Any]) -> None:
    """Load by load: in a mean axis with places, 100 % of weight was said to be missed."""
    package = with_all_modes(reference, K=coupled_stiffness()).package
    assert package.compliance is not None
    missing = np.diag(missing_compliance(package, package.compliance))
    largest = np.diag(package.compliance).max()
    assert np.abs(missing[: 6 * len(package.interfaces)]).max() < 1e-10 * largest
    assert np.abs(missing).max() < 3e-3 * largest  # of inertia: sections turn as they may


def nodal_velocities(beam: Beam, y: np.ndarray) -> np.ndarray:
    """Map (6 n, 6 + m) from the velocities of a model to those of its nodes, global."""
    m, n = beam.package.n_mode, beam.model.line.n_node
    A = rotation_matrix(y[3:7])
    shapes = np.moveaxis(beam.package.shapes_B, 0, 2)  # (n, 6, m)
    b = beam.package.nodes_B + shapes[:, :3] @ y[7 : 7 + m]
    J = np.zeros((n, 6, 6 + m))
    for k in range(n):
        J[k, :3, :3] = np.eye(3)
        J[k, :3, 3:6] = -A @ skew(b[k])
        J[k, 3:, 3:6] = A
        J[k, :3, 6:] = A @ shapes[k, :3]
        J[k, 3:, 6:] = A @ shapes[k, 3:]
    return J.reshape(6 * n, 6 + m)


def state_of(beam: Beam, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """State of a free beam whose nodes are displaced (6 n,) and move (6 n,) like that."""
    model = free_model(beam)
    y = at_rest(model)
    n, m = len(displacement), beam.package.n_mode
    x = np.linalg.solve(nodal_velocities(beam, y), displacement)
    y[:3] = x[:3]
    angle = np.linalg.norm(x[3:6])
    y[3] = np.cos(angle / 2)
    y[4:7] = np.sin(angle / 2) * x[3:6] / angle if angle > 0 else 0.0
    y[7 : 7 + m] = x[6:]
    y[model.n_pos : -1] = np.linalg.solve(nodal_velocities(beam, y), velocity)
    assert n == 6 + m
    return y


def end_positions(beam: Beam, y: np.ndarray) -> np.ndarray:
    """Global positions of root and tip at states y (k, n), (k, 2, 3)."""
    m = beam.package.n_mode
    out = []
    for state in y:
        A = rotation_matrix(state[3:7])
        ends = map(beam.interface, ("root", "tip"))
        out.append([state[:3] + A @ (i.position_B + i.phi_B @ state[7 : 7 + m]) for i in ends])
    return np.array(out)


def test_free_flight_keeps_its_momenta_and_does_not_know_the_frame() -> None:
    """A bar that turns and vibrates: conserved, and the same but for squares of the deflection.

    Its spin goes down with the deflection: the gyroscopic moments w x J w of its slices bend it in
    no frame (docs/modes.md), so that frames differ by J w^2 as well.
    """
    times = np.linspace(0.0, 0.12, 7)
    slender = SectionMass(1.0, CENTRE, 0.1 * ROTARY).matrix()
    beams = [with_all_modes(reference, elements=2, mass=slender) for reference in REFERENCES]
    line = beams[0].model.line
    rng = np.random.default_rng(2)
    shape = beams[0].modes.columns_B[:, :6] @ rng.normal(size=6)
    shape *= 1.0 / np.abs(shape).max()
    drift = np.array([0.3, 0.2, -0.1])
    gaps = []
    for size in (1e-3, 5e-4):
        spin = size * np.array([400.0, -700.0, 2000.0])
        displacement = size * shape
        b = line.nodes_B + displacement.reshape(-1, 6)[:, :3]
        velocity = np.hstack([drift + np.cross(spin, b), np.tile(spin, (len(b), 1))]).ravel()
        ends = []
        for beam in beams:
            model, y0 = free_model(beam), state_of(beam, displacement, velocity)
            y = simulate(model, y0, times, rtol=1e-10)
            energy = np.array([total_energy(model, state) for state in y])
            assert np.abs(energy / energy[0] - 1.0).max() < 1e-8
            for history in zip(*(momenta(model, state) for state in y), strict=True):
                series = np.array(history)
                assert np.abs(series - series[0]).max() < 1e-8 * np.linalg.norm(series[0])
            ends.append(end_positions(beam, y))
        gaps.append([np.abs(other - ends[0]).max() for other in ends[1:]])
    assert np.ptp(ends[0][:, 1] - ends[0][:, 0], axis=0).max() > 0.05
    large, small = np.array(gaps)
    assert (small < 0.02 * size).all()
    assert (large / small > 3.5).all()
