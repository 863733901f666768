"""Initial twist and curvature: values by two routes, closed forms, a solid bar, invariances."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from peers.solid_bar import compliance
from scipy.spatial.transform import Rotation

from plymotion.preprocess.section import helical
from plymotion.preprocess.section.helical import (
    CentralSolutions,
    central_solutions,
    change_of_resultants,
)
from plymotion.preprocess.section.recovery import unit_strains
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_problem import SectionProblem, section_problem, solve
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.preprocess.section.space.space import SectionSpace
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.math.rotations import skew
from plymotion.solver.package.common.materials import (
    Orthotropic,
    bond,
    isotropic,
    ply_rotation,
    rotated,
)

PLY = Orthotropic(142.0, 9.79, 9.79, 5.998, 5.998, 4.80, 0.42, 0.42, 0.42, 1.0)
ISO = isotropic(1.0, 0.3, 1.0).stiffness_M

# Two independent routes: this operator in other code, and a three-dimensional solid model.
CASES: dict[str, tuple[Any, ...]] = {
    "square": (
        (1.0, 1.0, 12, 12),
        (0.5, 0.3, -0.4),
        (),
        3e-6,
        "11 1.00689, 12 .00888547, 13 -.0108288, 14 .0122282, 15 -.0343370, 16 .0454863, "
        "22 .321621, 23 -.00171051, 24 .00941526, 25 -.00766835, 26 .000458100, 33 .320738, "
        "34 -.0124305, 35 .000436442, 36 -.00818166, 44 .0571508, 45 -.00126095, 46 .00160225, "
        "55 .0815797, 56 -.00243007, 66 .0820578",
    ),
    "rectangle, twisted": (
        (1.0, 0.25, 24, 8),
        (0.6, 0.0, 0.0),
        (),
        3e-6,
        "11 .234476, 14 .00950994, 22 .0662265, 25 .000924226, 33 .0595810, 36 -.00617929, "
        "44 .00241694, 55 .00124256, 66 .0193696",
    ),
    "rectangle, curved": (
        (1.0, 0.5, 16, 10),
        (0.0, 0.0, 0.5),
        (),
        3e-6,
        "11 .510701, 16 -.0292970, 22 .164027, 33 .152544, 34 .00971180, 44 .0117779, "
        "55 .0105883, 66 .0429935",
    ),
    "laminate, twisted": (
        (1.0, 0.2, 32, 12),
        (0.5, 0.0, 0.0),
        (45.0, -45.0),
        6e-5,
        "11 3.52935, 14 .224148, 22 .876778, 25 .00119803, 33 .357409, 36 -.109267, "
        "44 .0451844, 55 .0107535, 66 .267172",
    ),
}


def space_of(b: float, t: float, n_2: int, n_3: int, degree: int = 2) -> SectionSpace:
    sizes = {"width": b, "height": t, "elements_2": n_2, "elements_3": n_3}
    return SectionSpace(section_mesh(expand("rectangle", sizes), "bar").cells, degree)


def stiffness_of(space: SectionSpace, plies: tuple[float, ...] = (), C: Any = ISO) -> Any:
    """Stiffness of the cells: one material, or plies of equal thickness from low x3 to high."""
    out = np.broadcast_to(C, (space.n_cell, 1, 6, 6)).copy()
    if plies:
        t = np.ptp(space.x3)
        row = ((space.mesh.middles[:, 1] / t + 0.5) * len(plies)).astype(int)
        for i, angle in enumerate(plies):
            out[row == i] = rotated(PLY.stiffness_M, ply_rotation(angle))
    return out


def size_of(K: Any) -> Any:
    return np.sqrt(np.outer(np.diag(K), np.diag(K)))


@pytest.mark.parametrize(
    "name",
    [
        "square",
        pytest.param("rectangle, twisted", marks=pytest.mark.one_end),
        pytest.param("rectangle, curved", marks=pytest.mark.one_end),
        "laminate, twisted",
    ],
)
def test_values_by_two_routes(name: str) -> None:
    mesh, k, plies, tolerance, text = CASES[name]
    space = space_of(*mesh, degree=3)
    found = central_solutions(space, np.array(k), stiffness_of(space, plies))
    expected = np.zeros((6, 6))
    for part in text.split(","):
        place, value = part.split()
        i, j = int(place[0]) - 1, int(place[1]) - 1
        expected[i, j] = expected[j, i] = float(value)
    assert (np.abs(found.K - expected) / size_of(expected)).max() < tolerance
    assert found.residual < 1e-11


def test_sign_of_the_plies() -> None:
    """K14 = 0.135631 at k = 0 fixes it; the limit k -> 0 is the prismatic stiffness."""
    space = space_of(1.0, 0.2, 32, 12)
    C = stiffness_of(space, (45.0, -45.0))
    sizes = {"width": 1.0, "height": 0.2, "elements_2": 32, "elements_3": 12}
    problem = SectionProblem(section_mesh(expand("rectangle", sizes), "bar"), 2)
    prismatic = problem.solve(C).K
    assert prismatic[0, 3] == pytest.approx(0.135631, rel=1e-4)
    found = central_solutions(space, np.array([1e-13, 0.0, 0.0]), C).K
    assert scaled(found - prismatic, prismatic).max() < 1e-11


@pytest.fixture(scope="module")
def solved() -> tuple[SectionSpace, Any, Any, CentralSolutions]:
    space = space_of(1.0, 0.6, 6, 4)
    C = stiffness_of(space, (30.0, -50.0))
    k = np.array([0.5, 0.3, -0.4])
    return space, C, k, central_solutions(space, k, C)


@pytest.mark.one_end
def test_warping_does_no_work_on_central_stresses(solved: Any) -> None:
    """S = S_e - K^ N - N T with N = -P' W, whatever is pinned."""
    space, C, k, found = solved
    T = change_of_resultants(k)
    N = -space.load_along_beam(C @ unit_strains(space, found)).T @ found.W
    hat = np.zeros((6, 6))
    hat[:3, :3] = hat[3:, 3:] = skew(k)
    hat[:3, 3:] = skew(np.array([1.0, 0.0, 0.0]))
    S = np.linalg.inv(found.K)
    assert (np.abs(found.S_e - hat @ N - N @ T - S) / size_of(S)).max() < 1e-11
    assert found.residual < 1e-12


def test_stresses_integrate_to_their_resultants(solved: Any) -> None:
    space, C, _, found = solved
    stress = C @ unit_strains(space, found)
    P = space.load_along_beam(stress)
    assert np.abs(found.strains.Z.T @ P - np.eye(6)).max() < 1e-11


@pytest.mark.one_end
def test_mirror(solved: Any) -> None:
    """Mirrored in x3: k1 and k2 change sign, and so do the resultants F3, M1, M2."""
    space, _, k, found = solved
    mirrored = stiffness_of(space, (-50.0, 30.0))
    other = central_solutions(space, k * [-1.0, -1.0, 1.0], mirrored).K
    sign = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
    assert (np.abs(other * np.outer(sign, sign) - found.K) / size_of(found.K)).max() < 1e-11


@pytest.mark.one_end
def test_rotation(solved: Any) -> None:
    """Mesh, material and k turned together about x1."""
    space, C, k, found = solved
    A = Rotation.from_euler("x", 33.0, degrees=True).as_matrix()
    turned = SectionSpace(_moved(space, A[1:, 1:], np.zeros(2)))
    T = bond(A)
    K = central_solutions(turned, A @ k, T @ C @ T.T).K
    both = np.kron(np.eye(2), A)
    assert (np.abs(both.T @ K @ both - found.K) / size_of(found.K)).max() < 1e-11


def _moved(space: SectionSpace, A: Any, shift: Any) -> Any:
    return replace(space.mesh, points=space.mesh.points @ np.asarray(A).T + shift)


def test_another_reference_line() -> None:
    """Moved by d without twist: k -> k/g0, lengths by g0, S -> B' S B / g0."""
    space, C, k = space_of(1.0, 0.6, 6, 4), None, np.array([0.0, 0.3, -0.4])
    C = stiffness_of(space, (30.0, -50.0))
    S = np.linalg.inv(central_solutions(space, k, C).K)
    d = np.array([0.2, -0.15])
    g_0 = 1.0 - d[0] * k[2] + d[1] * k[1]
    moved = SectionSpace(_moved(space, np.eye(2), -d))
    B = np.eye(6)
    B[3:, :3] = skew(np.array([0.0, *d]))
    expected = B.T @ S @ B / g_0
    found = np.linalg.inv(central_solutions(moved, k / g_0, C).K)
    assert (np.abs(found - expected) / size_of(expected)).max() < 1e-11


def test_both_solvers_agree(monkeypatch: pytest.MonkeyPatch, solved: Any) -> None:
    """Waves of a slight curvature give what one factorisation does; less curvature takes it."""
    space, C, k, _ = solved
    by_waves, slighter, least = (central_solutions(space, s * k, C).K for s in (1e-4, 1e-11, 1e-20))
    monkeypatch.setattr(helical, "SLIGHT", 1.0)
    for found, share in ((by_waves, 1e-4), (slighter, 1e-11)):
        other = central_solutions(space, share * k, C).K
        assert scaled(other - found, found).max() < 1e-11
    assert scaled(least - slighter, slighter).max() < 1e-10


# closed forms


def disc(radius: float) -> SectionSpace:
    sizes = {"radius_2": radius, "radius_3": radius}
    return SectionSpace(section_mesh(expand("ellipse", sizes), "disc").cells)


@pytest.mark.one_end
def test_twist_of_a_disc_is_nothing() -> None:
    space = disc(1.0)
    C = stiffness_of(space)
    twisted = central_solutions(space, np.array([0.5, 0.0, 0.0]), C).K
    straight = central_solutions(space, np.array([1e-12, 0.0, 0.0]), C).K
    assert scaled(twisted - straight, straight).max() < 1e-6  # parabolic edges


def test_first_order_in_twist() -> None:
    """K14 = E k1 (Ip - J) of an isotropic section."""
    space, k_1 = space_of(1.0, 0.5, 20, 10), 1e-3
    K = central_solutions(space, np.array([k_1, 0.0, 0.0]), stiffness_of(space)).K
    J = K[3, 3] * 2.6
    Ip = (1.0 * 0.5**3 + 0.5 * 1.0**3) / 12.0
    assert K[0, 3] == pytest.approx(k_1 * (Ip - J), rel=1e-5)


@pytest.mark.one_end
def test_thin_strip() -> None:
    """K11 = E b t, K14 = E t b^3 k1 / 12, and 1 / S44 = G J + E t b^5 k1^2 / 180."""
    b, t, k_1 = 1.0, 0.005, 0.02
    found = analyse(
        {
            "mesh": expand("rectangle", {"width": b, "height": t}),
            "materials": {"m": {"kind": "isotropic", "E": 1.0, "nu": 0.3, "rho": 1.0}},
            "regions": {"section": {"plies": [{"material": "m"}]}},
            "initial_curvature": [k_1, 0.0, 0.0],
        },
        estimate=False,
    )
    K = found.K
    J = b * t**3 / 3.0 * (1.0 - 0.6302 * t / b)
    assert K[0, 0] == pytest.approx(b * t, rel=1e-3)
    assert K[0, 3] == pytest.approx(t * b**3 * k_1 / 12.0, rel=2e-3)
    assert 1.0 / np.linalg.inv(K)[3, 3] == pytest.approx(
        J / 2.6 + t * b**5 * k_1**2 / 180.0, rel=2e-3
    )
    # M per length of the arc, the same for every twist of a centred section
    assert found.M[0, 0] == pytest.approx(b * t, rel=1e-12)
    np.testing.assert_allclose(found.initial_curvature, [k_1, 0.0, 0.0])


@pytest.mark.parametrize("ratio", [5.0, 2.0, 1.0])
def test_curved_rectangle_is_golovins(ratio: float) -> None:
    """Bending of a strip of a ring at nu = 0: S66 and the stresses (R/h = 5, 2, 1)."""
    h, t, R = 1.0, 0.3, ratio
    a, c = R - 0.5 * h, R + 0.5 * h
    space = space_of(h, t, 24, 4, degree=3)
    C = isotropic(1.0, 0.0, 1.0).stiffness_M
    found = central_solutions(space, np.array([0.0, 0.0, 1.0 / R]), stiffness_of(space, C=C))
    N = (c**2 - a**2) ** 2 - 4.0 * a**2 * c**2 * np.log(c / a) ** 2
    S = np.linalg.inv(found.K)
    assert S[5, 5] == pytest.approx(8.0 * (c**2 - a**2) / (N * R * t), rel=2e-6)
    stress = (C @ unit_strains(space, found))[..., 5].reshape(-1, 6)
    r = R - space.points[..., 0].ravel()  # the centre lies at x2 = R
    hoop = (
        4.0
        / (N * t)
        * (
            -(a**2) * c**2 / r**2 * np.log(c / a)
            + c**2 * np.log(r / c)
            + a**2 * np.log(a / r)
            + c**2
            - a**2
        )
    )
    sign = np.sign(stress[np.argmax(np.abs(hoop)), 0] * hoop[np.argmax(np.abs(hoop))])
    assert stress[:, 0] == pytest.approx(sign * hoop, abs=2e-4 * np.abs(hoop).max())


@pytest.mark.one_end
def test_spring() -> None:
    """A coil of wire d, diameter D = c d: energy P^2 R^2 / (G J) (1 - 3 / (16 c^2) + O(c^-4))."""
    for c in (5.0, 10.0):
        space, R = disc(0.5), 0.5 * c
        S = np.linalg.inv(
            central_solutions(space, np.array([0.0, 0.0, 1.0 / R]), stiffness_of(space)).K
        )
        F = np.array([0.0, 0.0, 1.0, R, 0.0, 0.0])
        GJ = np.pi / 32.0 / 2.6
        assert (
            pytest.approx(R**2 / GJ * (1.0 - 3.0 / (16.0 * c**2)), rel=1.0 / c**4 + 1e-5)
            == F @ S @ F
        )


@pytest.mark.one_end
@pytest.mark.parametrize(
    ("sides", "k", "plies", "bricks"),
    [
        ((1.0, 1.0), (0.5, 0.3, -0.4), None, (25, 5, 5)),
        ((1.0, 0.5), (0.6, 0.0, 0.0), 30.0, (25, 6, 4)),
    ],
)
def test_solid_bar(sides: Any, k: Any, plies: float | None, bricks: Any) -> None:
    """Compliance against the energy in the middle of a helical bar of bricks."""
    C = ISO if plies is None else rotated(PLY.stiffness_M, ply_rotation(plies))
    space = space_of(*sides, 16, 12)
    S = np.linalg.inv(central_solutions(space, np.array(k), stiffness_of(space, C=C)).K)
    solid = compliance(sides, k, C, 10.0, bricks)
    assert (np.abs(solid - S) / size_of(S)).max() < 2e-3


@pytest.mark.one_end
def test_error_falls_with_the_fourth_power() -> None:
    k = np.array([0.5, 0.3, -0.4])
    spaces = [space_of(1.0, 1.0, n, n, 2) for n in (3, 6)]
    fine = space_of(1.0, 1.0, 8, 8, 4)
    exact = central_solutions(fine, k, stiffness_of(fine)).K
    errors = [
        scaled(central_solutions(s, k, stiffness_of(s)).K - exact, exact).max() for s in spaces
    ]
    assert np.log2(errors[0] / errors[1]) > 3.5


# the command


def described(**keys: Any) -> dict[str, Any]:
    return {
        "mesh": expand("rectangle", {"width": 0.1, "height": 0.05}),
        "materials": {"m": {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}},
        "regions": {"section": {"plies": [{"material": "m"}]}},
        **keys,
    }


@pytest.mark.one_end
def test_estimate_and_refinement_with_curvature() -> None:
    """The degree 3 is exact to a thousandth of the error: the section has no re-entrant corner."""
    spec = described(initial_curvature=[2.0, 0.0, 3.0])
    found, refined = analyse(spec), analyse(spec, accuracy=1e-5)
    exact = analyse({**spec, "mesh": {**spec["mesh"], "degree": 3}}, estimate=False).K
    for one in (found, refined):
        error = scaled(one.K - exact, exact).max()
        estimate = scaled(np.asarray(one.error_estimate), exact).max()
        assert error < estimate < 3.0 * error
        assert one.warnings == ()
    assert error < 1e-5 < scaled(found.K - exact, exact).max()


@pytest.mark.one_end
@pytest.mark.provokes("coarse-mesh")
def test_thin_twisted_strip_is_raised_in_degree() -> None:
    """Quadratic fields in long cells stretch where the wall only bends: K33 is twice too large."""
    spec = described(initial_curvature=[0.3, 0.0, 0.0])
    sizes = {"width": 1.0, "height": 1e-3, "density": 0.35}
    mesh = expand("rectangle", sizes)
    coarse = analyse({**spec, "mesh": {**mesh, "degree": 2}})
    found = analyse({**spec, "mesh": mesh})
    (warning,) = coarse.warnings
    assert warning["code"] == "coarse-mesh"
    assert found.warnings == ()
    assert found.provenance["degree"] > 2
    assert found.error_estimate is not None
    assert scaled(found.error_estimate, found.K).max() < 0.01
    # degree 4 with twice as many columns and rows: K22, K33, K66 over those of the flat strip
    flat = np.array([70e6 / 2.6, 70e6 / 2.6, 70e6 / 12.0])
    assert np.diag(found.K)[[1, 2, 5]] / flat == pytest.approx(
        np.array([4.876e-06, 8.149e-06, 2.305e-04]), rel=1e-3
    )


def without_trials(spec: dict[str, Any]) -> Any:
    """K (6, 6) of a description; its round-off is not measured, which is most of the work."""
    problem = section_problem(spec, "strip", spec["mesh"]["degree"])
    lay = layup(spec, problem.mesh, problem.space, "strip")
    return solve(problem, lay, "strip", spec, measured=False).K


@pytest.mark.one_end
def test_very_thin_twisted_strip_needs_a_high_degree_and_one_row() -> None:
    """t/b = 1e-5: rows across do not change a digit, and degrees up to 6 meet the estimate."""
    mesh = expand("rectangle", {"width": 1.0, "height": 1e-5, "density": 0.75})
    one_row = {**mesh, "parameters": {**mesh["parameters"], "rows": [1.0]}}
    spec = described(initial_curvature=[0.3, 0.0, 0.0])
    found = analyse({**spec, "mesh": one_row})
    assert found.warnings == ()
    assert found.provenance["degree"] > 4
    assert found.error_estimate is not None
    assert scaled(found.error_estimate, found.K).max() < 0.01
    finer = without_trials({**spec, "mesh": {**one_row, "degree": 6}})
    assert (scaled(found.K - finer, finer) <= 1.1 * scaled(found.error_estimate, found.K)).all()
    two_rows = {**mesh, "parameters": {**mesh["parameters"], "rows": [0.5, 1.0]}}
    meshes = [{**one, "degree": 4} for one in (one_row, two_rows)]
    K = [without_trials({**spec, "mesh": one}) for one in meshes]
    assert scaled(K[1] - K[0], K[0]).max() < 1e-6


@pytest.mark.one_end
@pytest.mark.provokes("strongly-curved")
def test_strong_curvature() -> None:
    (warning,) = analyse(described(initial_curvature=[0.0, 0.0, 12.0]), estimate=False).warnings
    assert warning["code"] == "strongly-curved"
    with pytest.raises(SectionError, match=r"beyond the centre of curvature: .* = -0.24"):
        analyse(described(initial_curvature=[0.0, 0.0, 25.0]))


@pytest.mark.one_end
@pytest.mark.provokes("taper-neglected")
def test_taper_is_in_the_estimate() -> None:
    plain, slight, strong = (
        analyse(described(**keys)) for keys in ({}, {"taper": 0.5}, {"taper": 2.0})
    )
    assert slight.warnings == ()
    assert [w["code"] for w in strong.warnings] == ["taper-neglected"]
    added = scaled(strong.error_estimate - plain.error_estimate, plain.K)
    assert added == pytest.approx(2.0 / 3.0 * (0.5 * 2.0 * 0.1) ** 2, rel=1e-6)
