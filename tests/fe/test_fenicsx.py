"""preprocess/fenicsx: eigenpairs, factorisation, gmsh scripts, messages when parts are missing."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
import ufl
from harness.processes import this_python
from samples.shell_specs import plate

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.spaces import cell_dofs, cell_name, dolfinx_mesh, vector_space
from plymotion.preprocess.section.space.section_mesh import script_path
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

ROOT = Path(__file__).resolve().parent.parent.parent
N = 120


def chain(n: int = N, *, free: bool = False) -> Any:
    """Stiffness of n equal springs between masses, in N/m; fixed at both ends or free."""
    diagonal = np.full(n, 2.0)
    if free:
        diagonal[[0, -1]] = 1.0
    off = -np.ones(n - 1)
    return sp.csr_matrix(sp.diags([off, diagonal, off], [-1, 0, 1]) * 1e9)


def exact(n_mode: int) -> Any:
    return 2e9 * (1 - np.cos(np.arange(1, n_mode + 1) * np.pi / (N + 1)))


@pytest.mark.parametrize("n_mode", [1, 6, 50, N - 1, N])
def test_eigenpairs_of_a_chain(n_mode: int) -> None:
    K, M = chain(), sp.identity(N, format="csr")
    values, X = fenicsx.eigenpairs(K, M, n_mode)
    assert values == pytest.approx(exact(n_mode), rel=1e-10)
    assert np.abs(X.T @ X - np.eye(n_mode)).max() < 1e-12
    assert np.abs(K @ X - X * values).max() < 1e-8 * values[-1]


@pytest.mark.parametrize("n_mode", [3, 59, 60])
def test_massless_unknowns(n_mode: int, record: Callable[[str, Any], None]) -> None:
    """Half of the masses zero: condensing them out by hand gives the same frequencies."""
    mass = np.ones(N)
    mass[1::2] = 0.0
    values, X = fenicsx.eigenpairs(chain(), sp.csr_matrix(sp.diags(mass)), n_mode)
    K = chain().toarray()
    a, b = np.flatnonzero(mass), np.flatnonzero(mass == 0)
    condensed = K[np.ix_(a, a)] - K[np.ix_(a, b)] @ np.linalg.solve(
        K[np.ix_(b, b)], K[np.ix_(b, a)]
    )
    assert values == pytest.approx(np.linalg.eigvalsh(condensed)[:n_mode], rel=1e-10)
    assert np.abs(X.T @ (mass[:, None] * X) - np.eye(n_mode)).max() < 1e-12
    record(f"eigenpairs/massless/{n_mode}", values)


def test_more_modes_than_masses() -> None:
    mass = np.zeros(N)
    mass[:10] = 1.0
    with pytest.raises(fenicsx.EigenError, match=r"11 modes requested.* 10 of finite"):
        fenicsx.eigenpairs(chain(), sp.csr_matrix(sp.diags(mass)), 11)


@pytest.mark.parametrize("n", [3, 10, 120, 1000])
def test_free_body_needs_a_negative_target(n: int) -> None:
    """Few masses are solved as a dense problem, many by iteration; one pivot is rounding."""
    K, M = chain(n, free=True), sp.identity(n, format="csr")
    with pytest.raises(fenicsx.EigenError, match="negative target"):
        fenicsx.eigenpairs(K, M, 2)
    values, X = fenicsx.eigenpairs(K, M, 2, target=-1e5)
    assert abs(values[0]) < 1e-6 * values[1]
    assert np.ptp(X[:, 0]) < 1e-8 * np.abs(X[:, 0]).max()


@pytest.mark.parametrize("slope", [0.1, 0.3, 0.7])
def test_singular_chain_is_known_whatever_its_last_pivot(slope: float) -> None:
    """Whether rounding leaves it exactly zero, negative or positive depends on the stiffnesses."""
    stiffness = 1e9 * (1.0 + slope * np.sin(np.arange(N - 1)))
    diagonal = np.concatenate([stiffness, [0.0]]) + np.concatenate([[0.0], stiffness])
    refused(sp.csr_matrix(sp.diags([-stiffness, diagonal, -stiffness], [-1, 0, 1])))


@pytest.mark.parametrize("thickness", [1e-2, 1e-4, 1e-6])
def test_free_plates_are_singular_however_thin(thickness: float) -> None:
    problem = ShellProblem(plate(8, thickness))
    refused(problem.freedom.reduced(problem.K))
    held = ShellProblem(plate(8, thickness, supports={"root": {"at": "left", "fixed": "all"}}))
    K = held.freedom.reduced(held.K)
    fenicsx.cholesky(K)
    fenicsx.eigenpairs(K, held.freedom.reduced(held.M), 3)


def refused(K: Any) -> None:
    """Both factorisations report that K is singular, as for a free body."""
    with pytest.raises(fenicsx.EigenError, match="negative target"):
        fenicsx.eigenpairs(K, sp.identity(K.shape[0], format="csr"), 3)
    with pytest.raises(fenicsx.FactorisationError, match="rigid motion"):
        fenicsx.cholesky(K)


def test_target_in_the_middle() -> None:
    values, _ = fenicsx.eigenpairs(chain(), sp.identity(N, format="csr"), 4, target=1e9)
    every = exact(N)
    nearest = np.sort(every[np.argsort(np.abs(every - 1e9))[:4]])
    assert values == pytest.approx(nearest, rel=1e-10)


def test_repeated_eigenvalues() -> None:
    """Two equal chains: every eigenvalue twice, both found, the same on each run."""
    K = sp.block_diag([chain(), chain()], format="csr")
    M = sp.identity(2 * N, format="csr")
    values, X = fenicsx.eigenpairs(K, M, 8)
    assert values == pytest.approx(np.repeat(exact(4), 2), rel=1e-10)
    assert np.array_equal(fenicsx.eigenpairs(K, M, 8)[1], X)


def test_cholesky_solves_and_updates() -> None:
    K = chain()
    B = np.random.default_rng(1).standard_normal((N, 3))
    factor = fenicsx.cholesky(K)
    assert np.abs(K @ factor.solve(B) - B).max() < 1e-10
    factor.update(3.0 * K)
    assert factor.solve(B[:, 0]) == pytest.approx(np.linalg.solve(3.0 * K.toarray(), B[:, 0]))
    with pytest.raises(fenicsx.FactorisationError, match="same sparsity"):
        factor.update(sp.identity(N, format="csr"))


@pytest.mark.parametrize("matrix", [chain(free=True), chain() - 1e9 * sp.identity(N)])
def test_cholesky_refuses_singular_and_indefinite(matrix: Any) -> None:
    with pytest.raises(fenicsx.FactorisationError, match="rigid motion"):
        fenicsx.cholesky(matrix)


@pytest.mark.parametrize(("name", "order"), [("rectangle", 9), ("ellipse", 9)])
def test_scripts_stand_alone(name: str, order: int) -> None:
    """The scripts mesh with their own defaults, as in the gmsh window."""
    plain = fenicsx.run_script(script_path(name), {}, gdim=2)
    mesh = dolfinx_mesh(plain)
    assert cell_name(mesh) == "quadrilateral"
    assert (plain.regions, set(plain.region)) == (("section",), {0})
    space = vector_space(mesh, 2, 3)
    assert cell_dofs(space).shape == (len(plain.cells), order)


def test_script_parameters_do_not_linger() -> None:
    sizes = {"width": 3.0, "height": 2.0, "columns": [0.5, 1.0], "rows": [0.3, 0.6, 1.0]}
    assert len(fenicsx.run_script(script_path("rectangle"), sizes, gdim=2).cells) == 6
    default = fenicsx.run_script(script_path("rectangle"), {}, gdim=2)
    assert np.ptp(default.points[:, 0]) == pytest.approx(0.06)


SQUARE = """
Point(1) = {0, 0, 0}; l[] = Extrude {1, 0, 0} { Point{1}; Layers{2}; };
s[] = Extrude {0, 1, 0} { Line{l[1]}; Layers{2}; Recombine; };
"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "no such gmsh script"),
        (SQUARE, "no physical surface, expected one for each region"),
        (
            SQUARE + 'Physical Surface("a") = {s[1]};\nPhysical Surface("b") = {s[1]};\n',
            "is in 2 physical groups",
        ),
        ("Point(1) = {0, 0, ;", "gmsh"),
    ],
)
def test_scripts_that_cannot_be_meshed(text: str | None, message: str, tmp_path: Path) -> None:
    path = tmp_path / "part.geo"
    if text is not None:
        path.write_text(text)
    with pytest.raises(fenicsx.MeshError, match=message):
        fenicsx.run_script(path, {}, gdim=2)


def test_unknown_parameter() -> None:
    with pytest.raises(fenicsx.MeshError, match="no parameter radius"):
        fenicsx.run_script(script_path("ellipse"), {"radius": 1.0}, gdim=2)


def test_versions_are_named() -> None:
    fenicsx.eigenpairs(sp.identity(3), sp.identity(3), 1)
    with fenicsx.gmsh_session():
        versions = fenicsx.versions()
    for name in ("dolfinx", "petsc", "slepc", "gmsh", "numpy", "h5py", "python"):
        assert versions[name][0].isdigit()


@pytest.mark.parametrize("missing", ["dolfinx", "gmsh", "slepc4py"])
def test_missing_part_is_named(missing: str) -> None:
    """An interpreter without one of the parts names the part and the remedy."""
    code = (
        f"import sys; sys.modules[{missing!r}] = None\n"
        "import plymotion.solver.package.common.materials\n"
        "try:\n    import plymotion.preprocess.fenicsx\n"
        "except ImportError as error:\n    print(type(error).__name__, error)\n"
    )
    done = this_python("-c", code, cwd=ROOT, more={"PYTHONPATH": str(ROOT)}, check=True)
    assert done.stdout.startswith("MissingFenicsx")
    assert missing in done.stdout
    assert "make fenicsx" in done.stdout


def test_what_a_compiled_text_would_read_beyond_is_refused() -> None:
    nodes = fenicsx.NODES["quadrilateral"][None] / 2.0
    points = fenicsx.quadrature("quadrilateral", 2)[0]

    def slopes(_domain: Any, u: Any, _k: Any) -> Any:
        return ufl.grad(u)

    found = fenicsx.evaluated(slopes, "quadrilateral", 2, points, nodes)
    assert found.shape == (1, len(points), 2, 9)
    assert fenicsx.evaluated(slopes, "quadrilateral", 2, points, nodes[:0]).shape[0] == 0
    with pytest.raises(ValueError, match="points"):
        fenicsx.evaluated(slopes, "quadrilateral", 2, np.zeros((501, 2)), nodes)
    for wrong in (nodes[:, :8], np.full_like(nodes, np.nan)):
        with pytest.raises(ValueError, match="nodes of quadrilaterals"):
            fenicsx.evaluated(slopes, "quadrilateral", 2, points, wrong)
