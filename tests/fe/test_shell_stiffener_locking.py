"""A rib that is stiff in the plane of its plate leaves the cells beside it their shear strain."""

from typing import Any

import numpy as np
import pytest
from samples.shell_specs import METAL, mesh_from, plate

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellMesh

SIDE, OFFSET = 0.06, 0.06
E = METAL["E"]
DIAGONAL = [E * SIDE**2, E * SIDE**2 / 3, E * SIDE**2 / 3, *[E * SIDE**4 / 12] * 3]
MASS = np.diag([1.0, 1.0, 1.0, 1e-3, 5e-4, 5e-4]).tolist()
TABLES: dict[str, Any] = {
    "supports": {"left": {"at": "left", "fixed": "all"}},
    "links": {"end": {"at": "right", "kind": "rigid"}},
    "loads": {
        "F": {"tip": {"at": "end", "force": [0.0, 0.3, 1.0]}},
        "S": {"tip": {"at": "end", "force": [0.0, 1.0, 0.0]}},
        "M": {"tip": {"at": "end", "moment": [1.0, 0.0, 0.0]}},
    },
}


def _rib(at: str, in_plane: float = 1.0) -> dict[str, Any]:
    factors = np.array([1.0, in_plane, 1.0, 1.0, 1.0, in_plane])
    stiffness = np.diag(DIAGONAL * factors).tolist()
    return {"at": at, "offset": [0.0, OFFSET], "stiffness": stiffness, "mass": MASS}


def _energy(n: int, in_plane: float, membrane: str, element: str = "triangle") -> float:
    """Strain energy of a cantilever with a rib along its free edge."""
    tables = {**TABLES, "stiffeners": {"rib": _rib("top", in_plane)}}
    spec = plate(n, 0.01, elements={"membrane": membrane}, **tables)
    spec["mesh"]["element"] = element
    return float(analyse(spec).cases.energy[0])


@pytest.mark.one_end
@pytest.mark.parametrize(
    ("membrane", "element"),
    [("opt", "triangle"), ("opt", "quadrilateral"), ("allman", "triangle"), ("cst", "triangle")],
)
@pytest.mark.parametrize("in_plane", [1.0, 1e-3])
def test_energy_converges_however_stiff_the_rib_is(
    membrane: str, element: str, in_plane: float
) -> None:
    """With one rotation for rib and cells it was 27 % too low with `opt`, 10 % with `allman`."""
    right = _energy(24, in_plane, "cst")
    assert _energy(8, in_plane, membrane, element) == pytest.approx(right, rel=0.01)


def _strip(n: int, fold: bool) -> ShellMesh:
    """2 n strips of cells along x, 0.6 m across, with a curve `mid` in the middle or at a fold."""
    x, s = np.linspace(0.0, 1.0, 3 * n + 1), np.linspace(-0.3, 0.3, 2 * n + 1)
    points = [[a, 0.0, b] if fold and b > 0.0 else [a, b, 0.0] for b in s for a in x]
    number = np.arange(len(points)).reshape(len(s), len(x))
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    cells = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    lines = {"mid": number[n], "left": number[:, 0], "right": number[:, -1]}
    curves = {name: np.stack([row[:-1], row[1:]], axis=1) for name, row in lines.items()}
    return mesh_from(points, cells, **curves)


def _folded(fold: bool) -> tuple[dict[str, Any], ShellMesh]:
    spec = plate(4, 0.005, **TABLES, stiffeners={"rib": _rib("mid")})
    return spec, _strip(4, fold)


@pytest.mark.one_end
@pytest.mark.parametrize("fold", [False, True])
def test_second_method_agrees_on_both_sides_of_a_rib(fold: bool) -> None:
    """Cells on its two sides have rotations of their own, as have two walls at a fold."""
    spec, mesh = _folded(fold)
    found = analyse(spec, mesh=mesh, verify=True)
    words = found.provenance["verification"]
    assert words.startswith("strain energy")
    assert not found.warnings
    difference, by_meshes = (float(word.split()[-1]) for word in words.split("%")[:2])
    assert difference < by_meshes, words


@pytest.mark.parametrize("fold", [False, True])
def test_rigid_motions_and_constant_strain_have_their_energy(fold: bool) -> None:
    spec, mesh = _folded(fold)
    problem = ShellProblem(spec, mesh=mesh)
    bare = ShellProblem({k: v for k, v in spec.items() if k != "stiffeners"}, mesh=mesh)
    rigid = problem.freedom.rigid_motions()
    assert np.abs(problem.K @ rigid).max() < 1e-9 * np.abs(problem.K).max()
    assert problem.beside is not None
    change = problem.beside.stiffness(problem.choice)
    assert np.abs(change @ rigid).max() < 1e-9 * np.abs(problem.K).max()
    if not fold:  # a shear strain: every node turns as the cells do, so nothing changes
        u = np.zeros((len(rigid) // 6, 6))
        u[: mesh.n_node, 0], u[: mesh.n_node, 5] = mesh.points_G[:, 1], -0.5
        strained = bare.K @ u.ravel()
        assert np.abs(change @ u.ravel()).max() < 1e-9 * np.abs(strained).max()


def test_resultants_and_second_order_see_the_same_corners() -> None:
    """The work of Kg, of a prestress by resultants, is that of the second-order forces."""
    from plymotion.preprocess.modes.reduced import pairs
    from plymotion.preprocess.shell.body.second_order import pair_forces

    spec, mesh = _folded(False)
    problem = ShellProblem(spec, mesh=mesh)
    rng = np.random.default_rng(3)
    u, v = rng.normal(size=(problem.freedom.n_dof, 2)), rng.normal(size=problem.freedom.n_dof)
    g = pair_forces(problem, u)
    expected = (u.T @ (problem.geometric_stiffness(v) @ u))[pairs(2)]
    np.testing.assert_allclose(v @ g, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
