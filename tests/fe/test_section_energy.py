"""The derivation behind the 6x6 stiffness: equilibrium, energy, pins, the paper's misprints."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.fenicsx import FactorisationError
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_problem import SectionProblem
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.section_warnings import result_warnings
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.preprocess.section.timoshenko import SectionStiffness, beam_strain_fields, stiffness
from plymotion.preprocess.section.warping import WarpingSolver, pinned_dofs, rigid_fields
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.package.common.materials import Orthotropic, isotropic, ply_rotation, rotated

GRAPHITE = Orthotropic(142e9, 9.8e9, 9.8e9, 6.0e9, 6.0e9, 4.8e9, 0.42, 0.42, 0.42, 1600.0)

Solved = tuple[SectionProblem, Any, SectionStiffness]


def rectangle(
    C_M: Any, angle_deg: float = 0.0, width: float = 0.03, height: float = 0.01, n: int = 6
) -> Solved:
    """A small rectangle of one ply: the problem, the stiffness of its points, its 6x6."""
    sizes = {"width": width, "height": height, "elements_2": n, "elements_3": 4}
    problem = SectionProblem(section_mesh(expand("rectangle", sizes), "test"), 2)
    C = rotated(C_M, ply_rotation(angle_deg))
    C = np.broadcast_to(C, (problem.space.n_cell, 1, 6, 6))
    return problem, C, problem.solve(C)


@pytest.fixture(scope="module")
def off_axis() -> Solved:
    return rectangle(GRAPHITE.stiffness_M, 30.0)


def test_warping_holds_no_rigid_motion(off_axis: Solved) -> None:
    problem, _, result = off_axis
    space = problem.space
    rigid = rigid_fields(space)
    load = space.load(space.at_points(rigid))
    for V in (result.V0, result.V1):
        size = np.linalg.norm(load, axis=0)[:, None] * np.linalg.norm(V, axis=0)
        assert (np.abs(load.T @ V) / size).max() < 1e-10


def test_choice_of_pins_does_not_matter(off_axis: Solved) -> None:
    problem, C, result = off_axis
    space = problem.space
    size = np.sqrt(np.diag(result.K))
    far, near = int(np.argmax(space.x2 + space.x3)), int(np.argmin(np.hypot(space.x2, space.x3)))
    for pins in (
        [3 * far, 3 * far + 1, 3 * far + 2, 3 * near + 1],
        [3 * near, 3 * far + 1, 3 * near + 2, 3 * far + 2],
    ):
        solver = WarpingSolver(space, np.array(pins))
        other = stiffness(space, solver, problem.space.E(C), C).K
        assert np.abs((other - result.K) / np.outer(size, size)).max() < 1e-10


def test_too_few_pins_are_noticed(off_axis: Solved) -> None:
    problem, C, _ = off_axis
    solver = WarpingSolver(problem.space, pinned_dofs(problem.space)[:3])
    with pytest.raises(FactorisationError, match="rigid motion"):
        solver.factorise(problem.space.E(C))


def test_load_on_a_rigid_motion_is_refused(off_axis: Solved) -> None:
    problem, C, _ = off_axis
    space, solver = problem.space, WarpingSolver(problem.space)
    solver.factorise(problem.space.E(C))
    load = space.load(space.at_points(space.displacements((1, 0, 0))))
    with pytest.raises(SectionError, match="on a rigid motion"):
        solver.solve(load, float(np.linalg.norm(load)))


@pytest.mark.provokes("few-digits")
def test_a_little_work_on_a_rigid_motion_is_told(off_axis: Solved) -> None:
    """Between round-off and a wrong equation there is a warning."""
    problem, C, result = off_axis
    assert result.solvability < 1e-12
    assert result_warnings(result) == []
    space, solver = problem.space, WarpingSolver(problem.space)
    solver.factorise(problem.space.E(C))
    fields = space.displacements((1, 0, 0), (space.x2, 0, 0))
    push, balanced = space.load(space.at_points(fields)).T[:, :, None]
    size = float(np.linalg.norm(balanced))
    solver.solve(balanced + 1e-8 * size / np.linalg.norm(push) * push, size)
    (warning,) = result_warnings(replace(result, solvability=solver.solvability))
    assert warning["code"] == "few-digits"


@pytest.mark.one_end
def test_thin_open_arc() -> None:
    """An arc of radius 400 times its wall: the exact stiffness of a strip rolled up."""
    arc = {"outer_radius": 0.4005, "wall": 0.001, "start_deg": 30.0, "span_deg": 120.0}
    spec = {
        "mesh": expand("tube", arc),
        "materials": {"m": {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}},
        "regions": {"wall": {"plies": [{"material": "m"}], "direction": {"circle": [0.0, 0.0]}}},
    }
    section = analyse(spec, estimate=False)
    area = np.radians(120.0) * 0.4 * 0.001
    assert section.K[0, 0] == pytest.approx(70e9 * area, rel=1e-6)
    # J = length wall^3 / 3, less the ends
    assert 1.0 / np.linalg.inv(section.K)[3, 3] == pytest.approx(
        70e9 / 2.6 * area * 0.001**2 / 3.0, rel=1e-3
    )
    assert section.warnings == ()


def test_printed_eq_44_gives_two_thirds_of_the_axial_stiffness() -> None:
    """A = C_ee + 2 V0' C_he of the paper: EA is 0.654 of the exact value (square, nu = 0.3)."""
    problem, C, result = rectangle(isotropic(1.0, 0.3, 1.0).stiffness_M, 0.0, 1.0, 1.0, 4)
    space = problem.space
    rigid = space.strain_along_beam(beam_strain_fields(space))
    warped = space.strain_in_section(result.V0)
    printed = space.work(C @ rigid, rigid) + 2.0 * space.work(C @ rigid, warped).T
    assert result.A[0, 0] == pytest.approx(1.0, rel=1e-10)  # E A
    # 2 E - C11 with C11 = E (1 - nu) / ((1 + nu) (1 - 2 nu))
    assert printed[0, 0] == pytest.approx(2.0 - 0.7 / (1.3 * 0.4), rel=1e-10)
    assert printed[0, 0] == pytest.approx(0.654, abs=5e-4)


def test_printed_eq_45_has_no_shear_energy_without_poisson() -> None:
    """R = V0' C_ll V0 + 2 V1' C_hl V0 is zero at nu = 0: bending causes no warping there."""
    problem, C, result = rectangle(isotropic(70e9, 0.0, 1.0).stiffness_M)
    space = problem.space
    change = space.strain_along_beam(result.V0 @ result.T)
    printed = space.work(C @ change, change)
    printed = printed + 2.0 * space.work(C @ change, space.strain_in_section(result.V1)).T
    true = np.linalg.inv(result.K)[1, 1]
    assert true == pytest.approx(1.2 / (35e9 * 0.03 * 0.01), rel=1e-2)
    assert np.abs(printed).max() < 1e-10 * true
