"""Reduction of imported matrices: frequencies, invariants, units, interfaces."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from samples.beam_samples import CLAMPED, reduced
from samples.brick_model import CORNERS, Brick, brick
from samples.exchange_samples import DENSITY, SIZE, TOTAL, bar, request

from plymotion.preprocess.exchange import from_matrices
from plymotion.solver.checks.statics import missing_compliance
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import ModalPackage, validate, write_package


@pytest.fixture(scope="module")
def body() -> Brick:
    return bar()


@pytest.fixture(scope="module")
def package(body: Brick) -> ModalPackage:
    cells = (body.cells + 1).tolist()
    return from_matrices(
        body.M, body.K, body.nodes, body.dofs, cells=cells, total_mass=TOTAL, **request()
    )


def lowest(K: Array, M: Array, count: int, shift: float = 0.0) -> Array:
    """Lowest eigenvalues, as the largest of M x = mu (K + shift M) x: round-off is relative."""
    inverse = scipy.linalg.eigh(M, K + shift * M, eigvals_only=True)[::-1][:count]
    return np.asarray(1.0 / inverse - shift)


def rigid_end(body: Brick, x: float) -> tuple[Array, Array, Array]:
    """Dofs of the nodes at x, and their motion with six dofs at the centre of the end."""
    rows = np.flatnonzero(np.abs(body.nodes[:, 0] - x) < 1e-9)
    arms = body.nodes[rows] - body.nodes[rows].mean(axis=0)
    block = np.zeros((len(rows), 3, 6))
    block[:, :, :3] = np.eye(3)
    for k in range(3):
        block[:, :, 3 + k] = np.cross(np.eye(3)[k], arms)
    return (3 * rows[:, None] + np.arange(3)).ravel(), block.reshape(-1, 6), arms


def held(body: Brick) -> np.ndarray:
    """Displacements by those of free nodes and the motion of the tip; the root is held."""
    n = 3 * len(body.nodes)
    root, _, _ = rigid_end(body, 0.0)
    tip, block, _ = rigid_end(body, SIZE[0])
    free = np.setdiff1d(np.arange(n), np.concatenate([root, tip]))
    T = np.zeros((n, len(free) + 6))
    T[free, np.arange(len(free))] = 1.0
    T[tip, len(free) :] = block
    return T


def test_frequencies_are_those_of_a_dense_solution(body: Brick, package: ModalPackage) -> None:
    """Root held, tip face rigid: eigenvalues of the dense matrices, constrained here by hand."""
    T = held(body)
    K, M = (T.T @ A.toarray() @ T for A in (body.K, body.M))
    values = lowest(K, M, 6)
    np.testing.assert_allclose(package.frequencies[:6] ** 2, values, rtol=1e-9)


def test_static_shapes_bend_as_the_dense_solution(body: Brick, package: ModalPackage) -> None:
    """A force at the tip: the modes together give the deflection of K u = f."""
    T = held(body)
    force = np.zeros(T.shape[1])
    force[-4] = 1.0
    u = np.linalg.solve(T.T @ body.K.toarray() @ T, force)
    place = package.interfaces[1]
    q = place.phi_B[2] / np.diag(package.stiffness)
    assert place.phi_B[2] @ q == pytest.approx(u[-4], rel=1e-9)
    assert place.psi_B[1] @ q == pytest.approx(u[-2], rel=1e-9)


def test_package_is_valid(package: ModalPackage, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.mktemp("package") / "arm.vtkhdf"
    write_package(file, package)
    assert validate(file) == []


def test_invariants_are_the_integrals_of_the_elements(body: Brick, package: ModalPackage) -> None:
    """Trilinear shapes squared are integrated exactly by three Gauss points per axis."""
    points, weights = np.polynomial.legendre.leggauss(3)
    h = np.array(SIZE) / (20, 3, 2)
    total = np.zeros((3, 3, package.n_mode, package.n_mode))
    first, T01 = np.zeros((3, package.n_mode)), np.zeros((3, 3, package.n_mode))
    shapes = package.shapes_B[:, : len(body.nodes), :3]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                at = 0.5 + 0.5 * np.array([points[i], points[j], points[k]])
                N = np.where(CORNERS == 1, at, 1.0 - at).prod(axis=1)
                dm = DENSITY * np.prod(h) / 8.0 * weights[i] * weights[j] * weights[k]
                x = np.einsum("l,cla->ca", N, body.nodes[body.cells])
                phi = np.einsum("l,mcla->cam", N, shapes[:, body.cells])
                first += dm * phi.sum(axis=0)
                T01 += dm * np.einsum("ca,cbm->abm", x, phi)
                total += dm * np.einsum("cai,cbj->abij", phi, phi, optimize=True)
    sums = package.invariants
    assert sums.mass_form == "consistent"
    for found, exact in ((sums.S_B, first), (sums.T01_B, T01), (sums.T11_B, total)):
        np.testing.assert_allclose(found, exact, atol=1e-12 * np.abs(exact).max())
    a, b, c = SIZE
    inertia = TOTAL * np.diag([a**2 / 3.0, b**2 / 12.0, c**2 / 12.0])
    np.testing.assert_allclose(sums.T00_B, inertia, atol=1e-14 * TOTAL)


def test_mean_axis_has_the_free_frequencies(body: Brick) -> None:
    package = from_matrices(
        body.M,
        body.K,
        body.nodes,
        body.dofs,
        **request(
            reference={"kind": "mean-axis"},
            interfaces={"tip": {"nodes": [1, 2, 5, 7], "link": "average"}},
        ),
    )
    values = lowest(body.K.toarray(), body.M.toarray(), 12, shift=1e5)[6:]
    np.testing.assert_allclose(package.frequencies[:6] ** 2, values, rtol=1e-8)
    assert np.abs(package.invariants.S_B).max() < 1e-9


def test_equal_frequencies_are_all_found() -> None:
    """A square bar has each bending frequency twice."""
    body = brick((0.5, 0.02, 0.02), (10, 2, 2))
    package = from_matrices(
        body.M, body.K, body.nodes, body.dofs, **request(modes=[{"kind": "lowest", "count": 3}])
    )
    f = package.frequencies
    assert f[1] == pytest.approx(f[0], rel=1e-9)
    assert f[2] > 2.0 * f[0]


def test_units_change_no_digit_that_matters(body: Brick, package: ModalPackage) -> None:
    """The same body in mm, t, s: N and MPa. Slender bending keeps nine digits of double numbers."""
    other = in_millimetres(body)
    np.testing.assert_allclose(other.frequencies, package.frequencies, rtol=1e-9)
    for name in ("T00_B", "S0_B"):
        mine, theirs = (getattr(p.invariants, name) for p in (package, other))
        np.testing.assert_allclose(theirs, mine, atol=1e-12 * np.abs(mine).max())


def test_units_of_a_compact_body_change_nothing() -> None:
    body = brick((SIZE[0], 0.2, 0.2), (6, 2, 2))
    package = from_matrices(body.M, body.K, body.nodes, body.dofs, **request())
    np.testing.assert_allclose(in_millimetres(body).frequencies, package.frequencies, rtol=1e-12)


def in_millimetres(body: Brick) -> ModalPackage:
    """Its package from matrices in N/mm and t."""
    boxes = {
        name: {**table, "box": (1e3 * np.array(table["box"])).tolist()}
        for name, table in request()["interfaces"].items()
    }
    return from_matrices(
        body.M / 1e3,
        body.K / 1e3,  # N/m to N/mm
        body.nodes * 1e3,
        body.dofs,
        units={"length": "mm", "mass": "t", "time": "s"},
        **request(interfaces=boxes),
    )


def test_area_weights_of_an_average_interface(body: Brick) -> None:
    """Corners of a regular face carry a quarter of the share of a node inside."""
    tables = request()["interfaces"]
    tables["tip"] |= {"link": "average", "weights": "area"}
    cells = (body.cells + 1).tolist()
    package = from_matrices(
        body.M, body.K, body.nodes, body.dofs, cells=cells, **request(interfaces=tables)
    )
    rows = np.flatnonzero(np.abs(body.nodes[:, 0] - SIZE[0]) < 1e-9)
    across = body.nodes[rows]
    share = np.where(np.abs(across[:, 1]) > 0.0199, 0.5, 1.0)
    share *= np.where(np.abs(across[:, 2]) > 0.0049, 0.5, 1.0)
    mean = np.einsum("k,mkd->dm", share / share.sum(), package.shapes_B[:, rows, :3])
    gap = np.abs(package.interfaces[1].phi_B - mean).max()
    assert gap < 1e-12 * np.abs(mean).max()


def test_six_dof_masses_keep_the_momentum(body: Brick) -> None:
    """A frame of beam elements: momentum and angular momentum of every mode from R'MX."""
    from samples.exchange_frames import frame

    nodes, dofs, K, M = frame()
    package = from_matrices(
        sp.csr_matrix(M),
        sp.csr_matrix(K),
        nodes,
        dofs,
        **request(
            interfaces={
                "root": {"nodes": [1], "link": "rigid"},
                "tip": {"nodes": [len(nodes)], "link": "rigid"},
            }
        ),
    )
    from plymotion.solver.package.body.invariants import free_body_mass, rigid_motions

    R = rigid_motions(nodes).reshape(-1, 6)
    X = package.shapes_B[:, : len(nodes)].reshape(package.n_mode, -1).T
    momentum = R.T @ M @ X
    scale = np.abs(momentum).max(axis=1, keepdims=True)
    assert (np.abs(free_body_mass(package)[:6, 6:] - momentum) < 1e-11 * scale + 1e-12).all()
    np.testing.assert_allclose(free_body_mass(package)[:6, :6], R.T @ M @ R, atol=1e-12)
    assert package.invariants.mass_form == "lumped"


def test_a_spin_loads_the_rotations_of_imported_nodes() -> None:
    """Angular acceleration of a bar: without them the missing energy was -9 %."""
    line = reduced(CLAMPED, [{"kind": "lowest", "count": 1}]).model.line
    dofs = [(node + 1, d) for node in range(line.n_node) for d in range(1, 7)]
    package = from_matrices(
        line.mass_matrix("consistent"),
        line.stiffness(),
        line.nodes_B,
        dofs,
        body="bar",
        interfaces={"root": {"nodes": [1], "link": "rigid"}},
        reference={"kind": "clamped", "at": "root"},
        modes=[{"kind": "lowest", "count": 8}],
    )
    C = package.compliance
    assert C is not None
    p = np.zeros(len(C))
    p[[-10, -4]] = 1.0, -1.0  # about y, as rows of A (3, 4)
    assert abs(p @ missing_compliance(package, C) @ p) < 1e-3 * (p @ C @ p)
