"""Choice, naming and uniqueness of modes (with SciPy's dense eigensolver)."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from plymotion.preprocess.beam.accuracy import coarse_mesh_warnings
from plymotion.preprocess.beam.line import BeamLine, section_axes
from plymotion.preprocess.beam.stations import mass_stations
from plymotion.preprocess.modes import (
    KINDS,
    EigenSolver,
    ModeError,
    ModeRequest,
    Modes,
    constrained_modes,
)

STIFFNESS = np.diag([7e7, 2e7, 2e7, 3e3, 6e3, 1.5e3])
MASS = 2.7 * np.diag([1, 1, 1, 1.1e-4, 9e-5, 2e-5])
SQUARE = np.diag([7e7, 2e7, 2e7, 3e3, 6e3, 6e3])
SQUARE_MASS = 2.7 * np.diag([1, 1, 1, 1.8e-4, 9e-5, 9e-5])


def dense(K: sp.csr_matrix, M: sp.csr_matrix, n_mode: int) -> tuple[np.ndarray, np.ndarray]:
    # the inverse pencil gives the lowest frequencies to round-off
    inverse, X = scipy.linalg.eigh(M.toarray(), K.toarray())
    values = 1.0 / inverse[::-1][:n_mode]
    return values, X[:, ::-1][:, :n_mode] * np.sqrt(values)


def modes_of(
    requests: list[tuple[str, int]],
    K: np.ndarray = STIFFNESS,
    mass: np.ndarray = MASS,
    *,
    elements: int = 10,
    reference: int = 0,
    x2: tuple[float, float, float] = (0.0, 1.0, 0.0),
    solver: EigenSolver = dense,
) -> Modes:
    x = np.linspace(0, 1.0, elements + 1)
    line = BeamLine(x, K, mass, section_axes(np.array(x2)))
    return constrained_modes(
        line.stiffness(),
        line.mass_matrix("consistent"),
        6 * reference + np.arange(6),
        [ModeRequest(*r) for r in requests],
        lambda columns: mass_stations(line, columns, "consistent").participation(),
        np.argsort(-np.abs(x - x[reference]), kind="stable"),
        solver,
    )


def test_requests_take_what_the_ones_before_have_left() -> None:
    modes = modes_of([("lowest", 3), ("bending-xz", 2), ("torsion", 1)])
    assert modes.labels == (
        "bending-xy 1",
        "bending-xz 1",
        "bending-xy 2",
        "bending-xz 2",
        "bending-xz 3",
        "torsion 1",
    )
    assert (np.diff(modes.values) > 0).all()
    assert modes_of([]).columns_B.shape == (66, 0)


@pytest.mark.parametrize("kind", KINDS)
def test_kind_is_where_the_mass_moves(kind: str) -> None:
    modes = modes_of([(kind, 3)])
    assert modes.labels == tuple(f"{kind} {i}" for i in (1, 2, 3))
    assert (modes.shares[:, KINDS.index(kind)] > 0.99).all()


def test_rolled_section_swaps_the_planes() -> None:
    plain, rolled = modes_of([("bending-xy", 3)]), modes_of([("bending-xz", 3)], x2=(0, 0, 1.0))
    assert np.allclose(plain.values, rolled.values, rtol=1e-10)


def test_square_section_separates_the_planes() -> None:
    modes = modes_of([("lowest", 6)], SQUARE, SQUARE_MASS)
    assert modes.labels == tuple(f"bending-{p} {i}" for i in (1, 2, 3) for p in ("xy", "xz"))
    assert np.allclose(modes.values[::2], modes.values[1::2], rtol=1e-10)
    columns = modes.columns_B.reshape(11, 6, 6)
    for i in range(6):
        across = columns[:, 2 - i % 2, i]
        assert np.abs(across).max() < 1e-9 * np.abs(columns[:, 1 + i % 2, i]).max()


def test_basis_and_signs_do_not_depend_on_the_solver() -> None:
    rng = np.random.default_rng(5)

    def scrambled(K: sp.csr_matrix, M: sp.csr_matrix, n: int) -> tuple[np.ndarray, np.ndarray]:
        values, X = dense(K, M, n)
        X = X * rng.choice([-1.0, 1.0], size=n)
        for i in range(0, n - 1):
            if values[i + 1] - values[i] < 1e-9 * values[i]:
                c, s = np.cos(1.0 + i), np.sin(1.0 + i)
                X[:, i : i + 2] = X[:, i : i + 2] @ np.array([[c, -s], [s, c]])
        return values, X

    a = modes_of([("lowest", 7)], SQUARE, SQUARE_MASS)
    b = modes_of([("lowest", 7)], SQUARE, SQUARE_MASS, solver=scrambled)
    assert a.labels == b.labels
    assert np.abs(a.columns_B - b.columns_B).max() < 1e-9 * np.abs(a.columns_B).max()


@pytest.mark.parametrize("reference", [0, 10])
def test_free_end_moves_in_the_positive_direction(reference: int) -> None:
    modes = modes_of([("bending-xy", 4), ("torsion", 2), ("axial", 1)], reference=reference)
    tip = modes.columns_B.reshape(11, 6, -1)[10 - reference]
    component = {"bending-xy": 1, "torsion": 3, "axial": 0}
    for i, label in enumerate(modes.labels):
        assert tip[component[label.split()[0]], i] > 0
    assert np.abs(modes.columns_B.reshape(11, 6, -1)[reference]).max() == 0.0


def test_a_mode_that_the_solver_misses_is_found() -> None:
    asked = []

    def forgetful(K: sp.csr_matrix, M: sp.csr_matrix, n: int) -> tuple[np.ndarray, np.ndarray]:
        # like a Krylov method that has one vector of a coinciding pair
        asked.append(n)
        values, X = dense(K, M, min(n + 1, K.shape[0]))
        keep = np.delete(np.arange(n + 1), 3) if len(asked) == 1 else np.arange(n)
        return values[keep], X[:, keep]

    modes = modes_of([("lowest", 4)], SQUARE, SQUARE_MASS, solver=forgetful)
    assert len(asked) == 2
    assert np.allclose(modes.values, modes_of([("lowest", 4)], SQUARE, SQUARE_MASS).values)


def test_more_modes_than_the_model_has() -> None:
    assert len(modes_of([("axial", 3)], elements=3).labels) == 3
    with pytest.raises(ModeError, match=r"4 of kind 'axial' asked for.*3 axial") as caught:
        modes_of([("axial", 4)], elements=3)
    assert "6 bending-xy" in str(caught.value)
    with pytest.raises(ModeError, match="19 of kind 'lowest'"):
        modes_of([("lowest", 19)], elements=3)
    assert len(modes_of([("lowest", 18)], elements=3).labels) == 18


def test_modes_that_are_not_orthonormal_are_refused() -> None:
    def sloppy(K: sp.csr_matrix, M: sp.csr_matrix, n: int) -> tuple[np.ndarray, np.ndarray]:
        values, X = dense(K, M, n)
        return values, X * (1 + 1e-6)

    with pytest.raises(ModeError, match=r"X'MX - I is 2\.\d+e-06"):
        modes_of([("lowest", 2)], solver=sloppy)


def test_warning_names_the_modes_and_their_error() -> None:
    assert coarse_mesh_warnings(("torsion 1",), np.array([0.004]), 8) == []
    (warning,) = coarse_mesh_warnings(("bending-xy 1", "torsion 1"), np.array([-0.002, -0.034]), 8)
    assert warning["code"] == "mesh-coarse-for-modes"
    assert "torsion 1 (3.4%)" in warning["message"]
    assert "bending" not in warning["message"]
