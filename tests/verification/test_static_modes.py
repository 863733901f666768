"""Static modes: exact deflections and resultants, and the beam whose middle is held."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg
from samples.beam_samples import (
    CLAMPED,
    MASS,
    NAMES,
    REFERENCES,
    ROTARY,
    STIFFNESS,
    Beam,
    coupled_stiffness,
    reduced,
)

from plymotion.preprocess.beam.line import SectionMass
from plymotion.preprocess.modes.reference import solve_definite
from plymotion.solver.dynamics.evaluation.accelerations import assemble
from plymotion.solver.dynamics.model.model import GROUND
from plymotion.solver.math.rotations import frame_from_axis
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, flexible_body
from plymotion.solver.package.body.invariants import rigid_motions

EVERYWHERE = [{"kind": "attachment", "at": name} for name in ("root", "mid", "tip")]
by_reference = pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)


def held_at_root(beam: Beam, at: str, direction: int) -> np.ndarray:
    """Frame motion and modal coordinates, clamped at the root, unit load at an interface."""
    C = beam.motion("root")
    n = C.shape[1]
    A = np.block([[beam.stiffness(), C.T], [C, np.zeros((6, 6))]])
    load = np.concatenate([beam.motion(at)[direction], np.zeros(6)])
    return np.linalg.solve(A, load)[:n]


@pytest.mark.parametrize("elements", [4, 16])
@by_reference
def test_static_deflection_under_a_force_is_that_of_beam_theory(
    reference: dict[str, Any], elements: int
) -> None:
    """F a^3 / 3 EI + F a / G A at the force, and F a^2 (3 L - a) / 6 EI + F a / G A at the tip."""
    modes = [{"kind": "bending-xy", "count": 2}]
    bare = reduced(reference, modes, elements=elements)
    beam = reduced(reference, [*modes, *EVERYWHERE], elements=elements)
    EI, GA, a = STIFFNESS[5, 5], STIFFNESS[1, 1], 0.5
    for at, arm in (("mid", 0.5), ("tip", 1.0)):
        a = arm
        expected = [a**3 / (3 * EI) + a / GA, a**2 * (3.0 - a) / (6 * EI) + a / GA]
        found = held_at_root(beam, at, 1)
        moved = [beam.motion(name)[1] @ found for name in (at, "tip")]
        assert moved == pytest.approx(expected, rel=1e-10)
    # A frame at the root needs no load there: the modes alone come near, elsewhere they do not.
    error = abs(beam_deflection(bare, "tip") / expected[0] - 1.0)
    assert error > (5e-3 if reference is CLAMPED else 0.05)


def beam_deflection(beam: Beam, at: str) -> float:
    return float(beam.motion(at)[1] @ held_at_root(beam, at, 1))


@by_reference
def test_static_deflection_of_a_coupled_beam_is_that_of_its_mesh(reference: dict[str, Any]) -> None:
    """All six unit loads at the middle, one eigenmode, full 6x6, against the FE model."""
    beam = reduced(
        reference, [{"kind": "lowest", "count": 1}, *EVERYWHERE], K=coupled_stiffness(), elements=8
    )
    K, node = beam.model.line.stiffness(), beam.model.node_of["mid"]
    loads = np.zeros((K.shape[0], 6))
    loads[6 * node + np.arange(6), range(6)] = 1.0
    fixed = solve_definite(K[6:, 6:], loads[6:])
    for direction in range(6):
        found = held_at_root(beam, "mid", direction)
        for name in ("mid", "tip"):
            first = 6 * beam.model.node_of[name] - 6
            expected = fixed[first : first + 6, direction]
            error = np.abs(beam.motion(name) @ found - expected).max()
            assert error < 1e-10 * np.abs(fixed[:, direction]).max()


@by_reference
def test_resultants_of_static_loads_are_those_of_equilibrium(reference: dict[str, Any]) -> None:
    """A force at the middle: F2 = F, M3 = F (a - x) before it, nothing behind it."""
    beam = reduced(reference, [{"kind": "lowest", "count": 4}, *EVERYWHERE], elements=8)
    recovery = beam.package.recovery
    assert recovery is not None
    q = held_at_root(beam, "mid", 1)[6:]
    resultants = recovery.resultants_E @ q
    x = recovery.station_x
    before = np.arange(len(x)) < np.flatnonzero(x == 0.5)[1]
    assert np.count_nonzero(x == 0.5) == 2
    assert resultants[:, 1] == pytest.approx(np.where(before, 1.0, 0.0), abs=1e-9)
    assert resultants[:, 5] == pytest.approx(np.where(before, 0.5 - x, 0.0), abs=1e-9)
    assert np.abs(resultants[:, [0, 2, 3, 4]]).max() < 1e-9


@by_reference
def test_spun_bar_stretches_as_it_should(reference: dict[str, Any]) -> None:
    """u(L) = m L^3 / 3 EA under the load m x: exact with its static mode, not with axial modes."""
    expected = MASS[0, 0] / (3.0 * STIFFNESS[0, 0])
    centred = SectionMass(1.0, np.zeros(3), ROTARY).matrix()
    ends = [{"kind": "attachment", "at": "root", "directions": ["x"]}]
    load = [{"kind": "static-axial"}]
    errors = []
    for modes in ([{"kind": "axial", "count": 2}], [*load, *ends]):
        beam = reduced(reference, modes, elements=8, mass=centred)
        line = beam.model.line
        field = np.zeros((line.n_node, 6))
        field[:, 0] = line.nodes_B[:, 0]
        load_on_nodes = line.mass_matrix("consistent") @ field.ravel()
        rigid = rigid_motions(line.nodes_B).reshape(6 * line.n_node, 6)
        columns = np.hstack([rigid, beam.modes.columns_B])
        C = beam.motion("root")
        A = np.block([[beam.stiffness(), C.T], [C, np.zeros((6, 6))]])
        x = np.linalg.solve(A, np.concatenate([columns.T @ load_on_nodes, np.zeros(6)]))
        errors.append(abs(beam.motion("tip")[0] @ x[:-6] / expected - 1.0))
    assert errors[0] > 1e-3
    assert errors[1] < 1e-10


# The actuated beam (reference/dynamics/01): box of lay-up 1, 5 kg at its tip, middle held.
EI, LINE_MASS, TIP_MASS = 247.80, 0.08389, 5.0
F1_HZ = 4.145  # Euler-Bernoulli, 16 elements
SLENDER = np.diag([5e8, 1e9, 1e9, 1e3, 3.0 * EI, EI])
SLENDER_MASS = LINE_MASS * np.diag([1.0, 1.0, 1.0, 2e-9, 1e-9, 1e-9])
FOUR = [{"kind": "bending-xy", "count": 4}]
AT_MIDDLE = [{"kind": "attachment", "at": "mid", "directions": ["y"]}]
AT_TIP = [{"kind": "attachment", "at": "tip", "directions": ["y"]}]
AT_ROOT = [{"kind": "attachment", "at": "root", "directions": ["y", "rz"]}]


def middle_held_hz(reference: dict[str, Any], modes: list[dict[str, Any]]) -> float:
    """First frequency from the solver's equations at rest: root fixed, middle on a line."""
    beam = reduced(reference, modes, elements=16, K=SLENDER, mass=SLENDER_MASS)
    markers = [
        MarkerTable(GROUND, np.zeros(3)),
        MarkerTable(GROUND, np.array([0.5, 0.0, 0.0]), frame_from_axis(np.array([1.0, 0.0, 0.0]))),
    ]
    for name in ("root", "mid", "tip"):
        i = beam.interface(name)
        markers.append(MarkerTable(0, i.position_B, np.eye(3), i.phi_B, i.psi_B))
    joints = [JointTable("R", "fixed", 0, 2), JointTable("M", "point_on_line", 1, 3)]
    body = flexible_body("beam", beam.package)
    model = assemble_model([body], markers, joints, [(4, TIP_MASS)])
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3] = 1.0
    equations = assemble(model, 0.0, y)
    free = scipy.linalg.null_space(equations.Phi_q, rcond=1e-9)
    M, K = (free.T @ A @ free for A in (equations.M, beam.stiffness()))
    return float(np.sqrt(1.0 / scipy.linalg.eigh(M, K, eigvals_only=True)[-1]) / (2.0 * np.pi))


def test_frequency_of_the_beam_held_at_its_middle() -> None:
    """Four modes and a shape of the force at M: within 0.5 %; with one at the mass too: exact."""
    with_middle = middle_held_hz(CLAMPED, [*FOUR, *AT_MIDDLE])
    assert with_middle == pytest.approx(F1_HZ, rel=5e-3)
    assert middle_held_hz(CLAMPED, FOUR) == pytest.approx(1.0037 * F1_HZ, rel=5e-4)
    assert with_middle == pytest.approx(1.0012 * F1_HZ, rel=5e-4)
    exact = middle_held_hz(CLAMPED, [*FOUR, *AT_MIDDLE, *AT_TIP])
    assert exact == pytest.approx(F1_HZ, rel=2e-4)


@by_reference
def test_held_beam_needs_shapes_of_all_that_acts_on_it(reference: dict[str, Any]) -> None:
    """A frame that is not at the root sees the reactions there as loads."""
    two = [{"kind": "bending-xy", "count": 2}]
    found = middle_held_hz(reference, [*two, *AT_MIDDLE, *AT_TIP, *AT_ROOT])
    assert found == pytest.approx(F1_HZ, rel=2e-4)
    without = middle_held_hz(reference, [*FOUR, *AT_MIDDLE, *AT_TIP])
    expected = {"clamped": 1.0, "chord": 1.0246, "mean-axis": 1.0393}
    assert without / F1_HZ == pytest.approx(expected[reference["kind"]], abs=5e-4)


def test_force_at_the_middle_without_its_shape() -> None:
    """Four clamped modes leave out 0.08 % of the deflection there, 1.3 % of the root moment."""
    exact = 0.5**3 / (3.0 * EI) + 0.5 / SLENDER[1, 1]
    errors = {}
    for name, modes in (("bare", FOUR), ("with", [*FOUR, *AT_MIDDLE])):
        beam = reduced(CLAMPED, modes, elements=16, K=SLENDER, mass=SLENDER_MASS)
        recovery = beam.package.recovery
        assert recovery is not None
        q = np.linalg.solve(beam.package.stiffness, beam.interface("mid").phi_B[1])
        deflection = beam.interface("mid").phi_B[1] @ q
        moment = recovery.resultants_E[0, 5] @ q  # at the clamp: 0.5 N m
        errors[name] = (deflection / exact - 1.0, moment / 0.5 - 1.0)
    assert errors["bare"] == pytest.approx((-8.2e-4, -1.26e-2), rel=0.01)
    assert errors["with"] == pytest.approx((0.0, 0.0), abs=1e-9)
