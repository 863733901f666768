"""The derivation behind the 6x6 stiffness: equilibrium, energy, pins, the paper's misprints."""

from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.materials import Orthotropic, isotropic, ply_rotation, rotated
from plymotion.preprocess.section import SectionError, timoshenko, warping
from plymotion.preprocess.section.forms import SectionMatrices, SectionSpace, section_space
from plymotion.preprocess.section.mesh import mesh_request

GRAPHITE = Orthotropic(142e9, 9.8e9, 9.8e9, 6.0e9, 6.0e9, 4.8e9, 0.42, 0.42, 0.42, 1600.0)


def matrices_of(C_M: Any, angle_deg: float = 0.0) -> tuple[SectionSpace, SectionMatrices]:
    """E, H, L of a small rectangle."""
    spec = {"shape": "rectangle", "width": 0.03, "height": 0.01, "elements": [6, 4]}
    space = section_space(mesh_request(spec, "test"))
    C = rotated(C_M, ply_rotation(angle_deg))
    return space, space.matrices(np.broadcast_to(C, (space.n_cell, 6, 6)))


@pytest.fixture(scope="module")
def off_axis() -> tuple[SectionSpace, SectionMatrices]:
    return matrices_of(GRAPHITE.stiffness_M, 30.0)


def test_stresses_of_the_solution_are_the_resultants(
    off_axis: tuple[SectionSpace, SectionMatrices],
) -> None:
    """For each of six unit loads: resultants of the stress = load, its energy = F' S F."""
    space, m = off_axis
    result = timoshenko.stiffness(space, m)
    Psi = warping.beam_strain_fields(space)
    T = np.linalg.solve(result.A, timoshenko.Q)
    _, B = timoshenko.shear_compliance(m, Psi, result.V0, result.V1, result.A, T)
    F = np.eye(6)
    F_c, F_s = F[timoshenko.CLASSICAL], F[timoshenko.SHEAR]
    e = np.linalg.solve(result.A, F_c - (B - B.T) @ T @ F_s)
    w = result.V0 @ e + result.V1 @ F_s
    along = result.V0 @ T @ F_s + Psi @ e  # w' + Psi e
    traction = m.H.T @ w + m.L @ along  # nodal work of the stresses on the section's face
    x2, x3 = space.x2, space.x3
    motions = space.displacements(
        (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -x3, x2), (x3, 0, 0), (-x2, 0, 0)
    )
    # compare in units of N and N m of the same size: lengths are about 1 cm
    size = np.array([1, 1, 1, 1e-2, 1e-2, 1e-2])
    resultants = motions.T @ traction
    assert np.abs(resultants / np.outer(size, 1 / size) - np.eye(6)).max() < 1e-9

    energy = w.T @ (m.E @ w) + along.T @ traction + w.T @ (m.H @ along)
    S = np.linalg.inv(result.K)
    size = np.sqrt(np.diag(S))
    assert np.abs((energy - S) / np.outer(size, size)).max() < 1e-9


def test_warping_holds_no_rigid_motion(off_axis: tuple[SectionSpace, SectionMatrices]) -> None:
    space, m = off_axis
    result = timoshenko.stiffness(space, m)
    rigid = warping.rigid_fields(space)
    load = space.area_gram @ rigid
    for V in (result.V0, result.V1):
        size = np.linalg.norm(load, axis=0)[:, None] * np.linalg.norm(V, axis=0)
        assert (np.abs(load.T @ V) / size).max() < 1e-10


def test_choice_of_pins_does_not_matter(off_axis: tuple[SectionSpace, SectionMatrices]) -> None:
    space, m = off_axis
    K = timoshenko.stiffness(space, m).K
    size = np.sqrt(np.diag(K))
    far, near = int(np.argmax(space.x2 + space.x3)), int(np.argmin(np.hypot(space.x2, space.x3)))
    for pins in (
        [3 * far, 3 * far + 1, 3 * far + 2, 3 * near + 1],
        [3 * near, 3 * far + 1, 3 * near + 2, 3 * far + 2],
    ):
        other = timoshenko.stiffness(space, m, np.array(pins)).K
        assert np.abs((other - K) / np.outer(size, size)).max() < 1e-10


def test_too_few_pins_are_noticed(off_axis: tuple[SectionSpace, SectionMatrices]) -> None:
    from plymotion.preprocess.fenicsx import FactorisationError

    space, m = off_axis
    with pytest.raises(FactorisationError, match="rigid motion"):
        timoshenko.stiffness(space, m, warping.pinned_dofs(space)[:3])


def test_load_on_a_rigid_motion_is_refused(
    off_axis: tuple[SectionSpace, SectionMatrices],
) -> None:
    space, m = off_axis
    solver = warping.WarpingSolver(space, m.E)
    load = space.area_gram @ space.displacements((1, 0, 0))
    with pytest.raises(SectionError, match="on a rigid motion"):
        solver.solve(load, float(np.linalg.norm(load)))


def test_printed_eq_44_gives_two_thirds_of_the_axial_stiffness() -> None:
    """A = C_ee + 2 V0' C_he of the paper: EA 0.654 of the truth for a square bar, nu = 0.3."""
    spec = {"shape": "rectangle", "width": 1.0, "height": 1.0, "elements": [4, 4]}
    space = section_space(mesh_request(spec, "test"))
    C = isotropic(1.0, 0.3, 1.0).stiffness_M
    m = space.matrices(np.broadcast_to(C, (space.n_cell, 6, 6)))
    Psi = warping.beam_strain_fields(space)
    result = timoshenko.stiffness(space, m)
    printed = Psi.T @ (m.L @ Psi) + 2.0 * result.V0.T @ (m.H @ Psi)
    assert result.A[0, 0] == pytest.approx(1.0, rel=1e-10)  # E A
    # 2 E - C11 with C11 = E (1 - nu) / ((1 + nu) (1 - 2 nu))
    assert printed[0, 0] == pytest.approx(2.0 - 0.7 / (1.3 * 0.4), rel=1e-10)
    assert printed[0, 0] == pytest.approx(0.654, abs=5e-4)


def test_printed_eq_45_has_no_shear_energy_without_poisson() -> None:
    """R = V0' C_ll V0 + 2 V1' C_hl V0 vanishes at nu = 0, where bending warps nothing."""
    space, m = matrices_of(isotropic(70e9, 0.0, 1.0).stiffness_M)
    result = timoshenko.stiffness(space, m)
    T = np.linalg.solve(result.A, timoshenko.Q)
    V0T = result.V0 @ T
    printed = V0T.T @ (m.L @ V0T) + 2.0 * result.V1.T @ (m.H @ V0T)
    true = np.linalg.inv(result.K)[1, 1]
    assert true == pytest.approx(1.2 / (35e9 * 0.03 * 0.01), rel=1e-2)
    assert np.abs(printed).max() < 1e-10 * true
