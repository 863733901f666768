"""Second-order displacements of shell bodies: reciprocity, beams, spinning strips and plates."""

from typing import Any

import numpy as np
import pytest
from samples.body_specs import shell_body, shell_parts
from samples.shell_specs import CFRP, METAL, box, plate

from plymotion.preprocess.body import build_body
from plymotion.preprocess.shell.analyses.frequencies import natural_modes
from plymotion.preprocess.shell.body.interfaces import read_shell_body
from plymotion.preprocess.shell.body.second_order import second_order_fields
from plymotion.preprocess.shell.body.shell_body import shell_model, shell_modes
from plymotion.preprocess.shell.model.freedom import Freedom
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.model.supports import read_supports
from plymotion.solver.package import read_package, write_package
from plymotion.solver.package.body.invariants import modal_mass_at

QUADS = {"element": "quadrilateral"}
LENGTH, WIDTH, THICKNESS = 1.0, 0.02, 0.005
WRIGHT = {1.0: 3.6817, 2.0: 4.1373, 3.0: 4.7973, 4.0: 5.5850, 5.0: 6.4495, 10.0: 11.2023}


def body(shell: dict[str, Any], ends: tuple[str, str], **changes: Any) -> dict[str, Any]:
    entries = {
        "shell": shell_parts(shell),
        "modes": [{"kind": "lowest", "count": 4}],
        "interfaces": {"root": {"at": ends[0]}, "tip": {"at": ends[1]}},
        "second_order": True,
        **changes,
    }
    return shell_body(body="strip", **entries)


def strip(n: tuple[int, int] = (40, 2), **changes: Any) -> dict[str, Any]:
    """A slender cantilever of metal in z = 0."""
    shell = plate(n, THICKNESS, LENGTH, WIDTH)
    shell["mesh"] |= changes.pop("cells", QUADS)
    return body(shell, ("left", "right"), **changes)


def skewed_box(**changes: Any) -> dict[str, Any]:
    shell = box((10, 2, 2))
    shell["mesh"] |= QUADS
    return body(shell, ("root", "tip"), **changes)


def offset_plate(**changes: Any) -> dict[str, Any]:
    """Unsymmetric plies off the mesh, and a stiffener: every coupling."""
    plies = [{"material": "cfrp", "angle_deg": float(a), "thickness": 1e-3} for a in (30, -45, 0)]
    shell = plate((10, 4), 1.0, 0.4, 0.1)
    shell["materials"] = {"cfrp": CFRP, "metal": METAL}
    shell["laminates"] = {"skin": {"plies": plies, "offset": 1e-3}}
    shell["regions"] = {"all": {"laminate": "skin", "axis": [1.0, 0.2, 0.0]}}
    K = np.diag([1e6, 4e5, 4e5, 20.0, 30.0, 30.0]).tolist()
    M = np.diag([0.1, 0.1, 0.1, 2e-6, 1e-6, 1e-6]).tolist()
    shell["stiffeners"] = {
        "rib": {"at": "bottom", "stiffness": K, "mass": M, "offset": [0.0, 0.01]}
    }
    return body(shell, ("left", "right"), **changes)


FRAMES = [{"kind": "clamped", "at": ["root"]}, {"kind": "mean-axis"}]


@pytest.mark.parametrize("reference", FRAMES, ids=lambda r: r["kind"])
@pytest.mark.parametrize("make", [strip, skewed_box, offset_plate])
def test_reciprocity(make: Any, reference: dict[str, Any]) -> None:
    """f . h_ij = -X_i' Kg(K^-1 f) X_j, without rigid interfaces that turn."""
    spec = make(reference=reference)
    spec["interfaces"]["tip"]["link"] = "average"
    if reference["kind"] == "mean-axis":
        spec["interfaces"]["root"]["link"] = "average"
    model = shell_model(read_shell_body(spec))
    modes = shell_modes(model)
    problem, condition = model.problem, model.condition
    u = problem.freedom.expanded(modes.columns_B)
    h = second_order_fields(problem, condition, u)
    rng = np.random.default_rng(1)
    load = rng.normal(size=(modes.columns_B.shape[0], 1))
    if reference["kind"] == "mean-axis":
        load = condition.static(load, np.zeros_like(load)).loads
    v = problem.freedom.expanded(condition.static(load, np.zeros_like(load)).columns)[:, 0]
    expected = -u.T @ (problem.geometric_stiffness(v) @ u)
    found = np.einsum("n,nij->ij", load[:, 0], h[problem.freedom.free])
    assert np.abs(found - expected).max() < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize("cells", [{}, QUADS], ids=["triangles", "quadrilaterals"])
def test_flap_of_a_spinning_strip(cells: dict[str, str]) -> None:
    """Wright et al. 1982: frequency over sqrt(EI/(m L^4)) against the spin over the same."""
    spec = strip(cells=cells, modes=[{"kind": "bending-xz", "count": 4}])
    spec["shell"]["materials"]["metal"] = {**METAL, "nu": 0.0}
    spec["interfaces"]["tip"]["link"] = "average"
    package = build_body(spec)
    EI = METAL["E"] * WIDTH * THICKNESS**3 / 12.0
    unit = np.sqrt(EI / (METAL["rho"] * WIDTH * THICKNESS * LENGTH**4))
    # spin about z: the plane of rotation is x-y, flap is along z
    second = package.second_order
    assert second is not None
    stiffening = -(second.Z1_B[0, 0] + second.Z1_B[1, 1])
    for spin, expected in WRIGHT.items():
        K = package.stiffness + (spin * unit) ** 2 * stiffening
        found = np.sqrt(np.linalg.eigvalsh(K)[0]) / unit
        assert found == pytest.approx(expected, rel=2e-3)


def mean(y: np.ndarray) -> float:
    """Mean over equal steps."""
    return float(0.5 * (y[1:] + y[:-1]).mean())


def test_sums_of_a_strip_are_those_of_a_beam() -> None:
    spec = strip((40, 2), modes=[{"kind": "bending-xz", "count": 2}])
    spec["shell"]["materials"]["metal"] = {**METAL, "nu": 0.0}
    package = build_body(spec)
    second = package.second_order
    assert second is not None
    first = 1.8751040687
    # h_11 at the tip and its moments, of a slender cantilever's first mode of unit modal mass
    x = np.linspace(0.0, 1.0, 4001)
    s = (np.cosh(first) + np.cos(first)) / (np.sinh(first) + np.sin(first))
    slope = first * (np.sinh(first * x) + np.sin(first * x)
                     - s * (np.cosh(first * x) - np.cos(first * x)))  # fmt: skip
    mass = METAL["rho"] * WIDTH * THICKNESS * LENGTH
    shortening = -np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] ** 2 + slope[:-1] ** 2))])
    shortening = shortening * (x[1] / (mass * LENGTH))  # modes have the value 2 at the tip
    tip = next(place for place in package.interfaces if place.name == "tip")
    assert tip.H_B is not None
    assert tip.H_B[0, 0, 0] == pytest.approx(shortening[-1], rel=3e-3)
    exact = mass * mean(shortening)
    assert second.Z0_B[0, 0, 0] == pytest.approx(exact, rel=3e-3)
    exact = mass * LENGTH * mean(x * shortening)
    assert second.Z1_B[0, 0, 0, 0] == pytest.approx(exact, rel=3e-3)
    q = np.array([0.3, -0.1]) / np.sqrt(package.frequencies)
    assert np.linalg.eigvalsh(modal_mass_at(package, q))[0] > 0.0


def test_rigid_interface_turns_with_its_nodes() -> None:
    """A wide strip: the nodes of its rigid tip follow a rotation about x to second order."""
    shell = plate((10, 4), 0.005, 0.5, 0.2)
    shell["mesh"] |= QUADS
    spec = body(shell, ("left", "right"), modes=[{"kind": "lowest", "count": 3}])
    model = shell_model(read_shell_body(spec))
    modes = shell_modes(model)
    problem = model.problem
    u = problem.freedom.expanded(modes.columns_B)
    h = second_order_fields(problem, model.condition, u).reshape(-1, 6, 3, 3)
    link = problem.links[1]
    reference = problem.mesh.n_node + 1
    turn = u.reshape(-1, 6, 3)[reference, 3:]
    for node in link.group.nodes:
        d = problem.mesh.points_G[node] - link.point_G
        for i in range(3):
            exact = np.cross(turn[:, i], np.cross(turn[:, i], d))
            exact += h[reference, :3, i, i] + np.cross(h[reference, 3:, i, i], d)
            assert np.allclose(h[node, :3, i, i], exact, atol=1e-12 * np.abs(h).max())


@pytest.mark.one_end
def test_package_keeps_the_second_order(tmp_path: Any) -> None:
    package = build_body(strip((8, 2)))
    write_package(tmp_path / "a.vtkhdf", package)
    again = read_package(tmp_path / "a.vtkhdf")
    assert again.second_order is not None
    assert np.array_equal(again.second_order.Z1_B, package.second_order.Z1_B)
    assert build_body(strip((8, 2), second_order=False)).second_order is None


@pytest.mark.one_end
@pytest.mark.parametrize(("count", "ratio", "bound"), [(4, 5.0, 2e-3), (12, 10.0, 1e-3)])
def test_spinning_square_plate(count: int, ratio: float, bound: float) -> None:
    """Modes at rest with second-order data against the plate under its centrifugal stresses.

    The plate is clamped at x = 0 and spins about z through the middle of that edge; `ratio` is the
    spin over sqrt(D/(m a^4)). f1 rises to 1.85 and 3.2 times its value at rest.
    """
    shell = plate((16, 16), 0.01)
    shell["mesh"] |= QUADS
    spec = body(shell, ("left", "right"), modes=[{"kind": "bending-xz", "count": count}])
    spec["interfaces"]["tip"]["link"] = "average"
    model = shell_model(read_shell_body(spec))
    package = build_body(spec)
    problem, condition = model.problem, model.condition
    D = METAL["E"] * 0.01**3 / (12.0 * (1.0 - METAL["nu"] ** 2))
    spin = ratio * np.sqrt(D / (METAL["rho"] * 0.01))
    outwards = np.zeros((problem.freedom.n_dof, 1))
    places = problem_places(problem) - [0.0, 0.5, 0.0]
    outwards[0::6, 0], outwards[1::6, 0] = places.T[:2]
    load = spin**2 * problem.freedom.gathered(problem.M @ outwards)
    u = problem.freedom.expanded(condition.static(load, np.zeros_like(load)).columns)
    stressed = (problem.K + problem.geometric_stiffness(u[:, 0])).tocsr()
    exact = natural_modes(
        stressed, problem.M, held(problem), 2, np.zeros((problem.freedom.n_dof, 0))
    ).values[0]
    second = package.second_order
    assert second is not None
    stiffening = -(second.Z1_B[0, 0] + second.Z1_B[1, 1] - 0.5 * second.Z0_B[1])
    found = np.linalg.eigvalsh(package.stiffness + spin**2 * stiffening)[0]
    assert np.sqrt(found / exact) == pytest.approx(1.0, abs=bound)
    assert found > 1.5 * package.stiffness[0, 0]


def problem_places(problem: ShellProblem) -> np.ndarray:
    """Positions of all nodes and reference points, (n, 3)."""
    ends = [link.point_G[None] for link in problem.links]
    return np.concatenate([problem.mesh.points_G, *ends])


def held(problem: ShellProblem) -> Freedom:
    """The degrees of freedom with the clamped edge fixed."""
    support = read_supports(
        {"root": {"at": "root", "fixed": "all"}}, problem.mesh, problem.links, "supports"
    )
    return Freedom(problem.mesh, problem.links, support)
