"""Choice, naming and uniqueness of modes, static ones too (with SciPy's dense eigensolver)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from samples.beam_samples import (
    CHORD,
    CLAMPED,
    MEAN_AXIS,
    NAMES,
    REFERENCES,
    dense,
    reduced,
    straight_line,
)

from plymotion.preprocess.beam.beam_body import coarse_mesh_warnings
from plymotion.preprocess.beam.beam_stations import mass_stations
from plymotion.preprocess.beam.line import section_axes
from plymotion.preprocess.modes.eigenmodes import KINDS, ModeRequest
from plymotion.preprocess.modes.reduced import Modes, StaticLoad, reduced_modes
from plymotion.preprocess.modes.reference import EigenSolver, HeldDofs, ModeError
from plymotion.solver.package.specification import DIRECTIONS

STIFFNESS = np.diag([7e7, 2e7, 2e7, 3e3, 6e3, 1.5e3])
MASS = 2.7 * np.diag([1, 1, 1, 1.1e-4, 9e-5, 2e-5])
SQUARE = np.diag([7e7, 2e7, 2e7, 3e3, 6e3, 6e3])
SQUARE_MASS = 2.7 * np.diag([1, 1, 1, 1.8e-4, 9e-5, 9e-5])


def modes_of(
    requests: list[tuple[str, int]],
    K: np.ndarray = STIFFNESS,
    mass: np.ndarray = MASS,
    *,
    elements: int = 10,
    reference: int = 0,
    x2: tuple[float, float, float] = (0.0, 1.0, 0.0),
    solver: EigenSolver = dense,
    loads: Sequence[StaticLoad] = (),
) -> Modes:
    x = np.linspace(0, 1.0, elements + 1)
    line = straight_line(x, K, mass, section_axes(np.array(x2)))
    return reduced_modes(
        HeldDofs(line.stiffness(), line.mass_matrix("consistent"), 6 * reference + np.arange(6)),
        [ModeRequest(*r) for r in requests],
        loads,
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
    with pytest.raises(ModeError, match=r"4 of kind 'axial' requested.*3 axial") as caught:
        modes_of([("axial", 4)], elements=3)
    assert "6 bending-xy" in str(caught.value)
    with pytest.raises(ModeError, match="19 of kind 'lowest'"):
        modes_of([("lowest", 19)], elements=3)
    assert len(modes_of([("lowest", 18)], elements=3).labels) == 18


def test_modes_that_are_not_orthonormal_are_refused() -> None:
    def sloppy(K: sp.csr_matrix, M: sp.csr_matrix, n: int) -> tuple[np.ndarray, np.ndarray]:
        values, X = dense(K, M, n)
        return values, X * (1 + 1e-6)

    with pytest.raises(ModeError, match=r"X'MX - I is 2\.\d+e-06.* are all sizes in m\?"):
        modes_of([("lowest", 2)], solver=sloppy)


def test_warning_names_the_modes_and_their_error() -> None:
    assert coarse_mesh_warnings(("torsion 1",), np.array([0.004]), 8) == []
    (warning,) = coarse_mesh_warnings(("bending-xy 1", "torsion 1"), np.array([-0.002, -0.034]), 8)
    assert warning["code"] == "mesh-coarse-for-modes"
    assert "torsion 1 (3.4%)" in warning["message"]
    assert "bending" not in warning["message"]


def attachments(*at: str, directions: str = "x y z rx ry rz") -> list[dict[str, Any]]:
    return [{"kind": "attachment", "at": name, "directions": directions.split()} for name in at]


THREE = [{"kind": "bending-xy", "count": 3}]


@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
def test_static_modes_are_orthonormal_and_have_the_reduced_frequencies(
    reference: dict[str, Any], mass_form: str
) -> None:
    asked = [*THREE, *attachments("mid", "tip"), {"kind": "static-axial"}]
    beam = reduced(reference, asked, elements=8, mass_form=mass_form)
    X, values, line = beam.modes.columns_B, beam.modes.values, beam.model.line
    M, K = line.mass_matrix(mass_form), line.stiffness()
    assert np.abs(X.T @ (M @ X) - np.eye(len(values))).max() < 1e-11
    scale = np.sqrt(np.outer(values, values))
    assert np.abs((X.T @ (K @ X) - np.diag(values)) / scale).max() < 1e-10
    assert beam.package.mode_kinds == ("fixed_normal",) * 3 + ("attachment",) * (len(values) - 3)
    assert (np.diff(values[:3]) > 0).all()
    assert (np.diff(values[3:]) > 0).all()
    # what a static mode is called is what moves it, in the positive direction
    for label, column in zip(beam.modes.labels[3:], X[:, 3:].T, strict=True):
        if label.startswith("attachment"):
            _, at, direction = label.split()
            row = DIRECTIONS.index(direction)
            assert column[6 * beam.model.node_of[at] + row] > 0.0


def test_static_modes_of_a_square_section_separate_the_planes() -> None:
    beam = reduced(
        CLAMPED,
        [{"kind": "lowest", "count": 2}, *attachments("mid", directions="z y")],
        K=SQUARE,
        mass=SQUARE_MASS,
    )
    assert beam.modes.labels[2:] == ("attachment mid y", "attachment mid z")
    assert beam.modes.values[2] == pytest.approx(beam.modes.values[3], rel=1e-9)
    shapes = np.abs(beam.package.shapes_B).max(axis=1)
    assert shapes[2, 2] < 1e-9 * shapes[2, 1]
    assert shapes[3, 1] < 1e-9 * shapes[3, 2]


def test_two_ends_of_a_free_beam_share_their_modes_in_order() -> None:
    """Root and tip have equal claims on the even and the odd shape."""
    ends = attachments("root", "tip", directions="y")
    beam = reduced(MEAN_AXIS, ends, mass=MASS, K=STIFFNESS)
    assert beam.modes.labels == ("attachment root y", "attachment tip y")
    even, odd = (beam.package.shapes_B[:, [0, -1], 1][i] for i in range(2))
    assert even == pytest.approx([even[0], even[0]], rel=1e-9)
    assert odd == pytest.approx([-odd[1], odd[1]], rel=1e-9)
    assert even[0] > 0
    assert odd[1] > 0


@pytest.mark.provokes("static-modes-dependent")
@pytest.mark.parametrize(
    ("reference", "modes", "dropped"),
    [
        # a frame at the root carries what acts there
        (CLAMPED, attachments("root", directions="y rz"), "attachment root y, attachment root rz"),
        (CHORD, attachments("root", "tip", directions="z ry"), "attachment root z, attachment tip"),
        # asked for twice
        (CLAMPED, attachments("mid", "mid", directions="y"), "attachment mid y:"),
        # all modes that there are leave nothing out
        (MEAN_AXIS, [{"kind": "lowest", "count": 24}, *attachments("mid")], "and 1 more:"),
        (CLAMPED, [{"kind": "lowest", "count": 24}, {"kind": "static-axial"}], "static-axial:"),
    ],
)
def test_dependent_static_modes_are_left_out_with_a_warning(
    reference: dict[str, Any], modes: list[dict[str, Any]], dropped: str
) -> None:
    beam = reduced(reference, modes)
    (warning,) = beam.modes.warnings
    assert warning["code"] == "static-modes-dependent"
    assert dropped in warning["message"]
    assert beam.package.n_mode <= 24


def test_load_that_the_frame_carries_but_for_round_off_takes_no_mode() -> None:
    """As rigid links of a solid leave it: its shape of round-off was taken, a true one was not."""
    forces = np.eye(66)[[1, 63, 64, 65]]
    forces[0, 60:] = 1e-18 * np.array([0.0, 1.0, -2.0, 3.0, 1.0, 2.0])
    labels = ("held y", "tip rx", "tip ry", "tip rz")
    rest = np.zeros(66)
    loads = [StaticLoad(a, force, rest) for a, force in zip(labels, forces, strict=True)]
    modes, expected = (modes_of([("lowest", 3)], loads=some) for some in (loads, loads[1:]))
    assert set(modes.labels[3:]) == set(labels[1:])
    assert modes.values == pytest.approx(expected.values, rel=1e-9)
    assert modes.warnings[0]["message"].startswith("no mode for held y:")


def test_static_shapes_that_move_no_mass_are_left_out() -> None:
    """A twist of a body without twist inertia; the others are there, very stiff ones too."""
    thin = np.diag([1.0, 1.0, 1.0, 0.0, 1e-9, 1e-9])
    beam = reduced(CLAMPED, [*THREE, *attachments("mid")], mass=thin, elements=32)
    (warning,) = beam.modes.warnings
    assert warning["message"].startswith("no mode for attachment mid rx:")
    assert "moves no mass" in warning["message"]
    assert beam.package.n_mode == 3 + 5
    X, values = beam.modes.columns_B, beam.modes.values
    assert values.max() / values.min() > 1e4
    M = beam.model.line.mass_matrix("consistent")
    assert np.abs(X.T @ (M @ X) - np.eye(8)).max() < 1e-11


def test_independent_static_modes_are_all_there() -> None:
    beam = reduced(MEAN_AXIS, [*THREE, *attachments("root", "mid", "tip")])
    assert beam.modes.warnings == ()
    assert beam.package.n_mode == 3 + 18
    assert set(beam.modes.labels[3:]) == {
        f"attachment {at} {d}" for at in ("root", "mid", "tip") for d in DIRECTIONS
    }


def test_body_without_modes() -> None:
    for reference in REFERENCES:
        beam = reduced(reference, [])
        assert beam.package.n_mode == 0
        assert beam.package.invariants.S_B.shape == (3, 0)


def test_mean_axis_needs_inertia_about_every_axis() -> None:
    thin = np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    with pytest.raises(ModeError, match="mean-axis frame needs inertia about every axis"):
        reduced(MEAN_AXIS, THREE, mass=thin)
    assert reduced(CHORD, THREE, mass=thin).package.n_mode == 3


@pytest.mark.parametrize("left", [1e-30, 1e-24, 1e-18])
def test_inertia_that_is_rounding_is_none(left: float) -> None:
    """A product of inertia and moments that rounding leaves of a section of points."""
    thin = np.diag([1.0, 1.0, 1.0, 2.0 * left, left, left])
    with pytest.raises(ModeError, match="mean-axis frame needs inertia about every axis"):
        reduced(MEAN_AXIS, THREE, mass=thin)


def test_free_free_frequencies_of_a_slender_bar() -> None:
    """Bending of a free bar: (k L)^2 = 22.3733, 61.6728; torsion pi c / L."""
    E_I, m = 1.0, 1.0
    K = np.diag([1e6, 1e6, 1e6, 2.0, 4.0 * E_I, E_I])
    mass = m * np.diag([1.0, 1.0, 1.0, 2e-7, 1e-7, 1e-7])
    asked = [{"kind": "bending-xy", "count": 2}, {"kind": "torsion", "count": 1}]
    beam = reduced(MEAN_AXIS, asked, elements=24, K=K, mass=mass)
    assert beam.modes.labels == ("bending-xy 1", "bending-xy 2", "torsion 1")
    expected = [22.373285, 61.672823, np.pi * np.sqrt(2.0 / 2e-7)]
    assert beam.package.frequencies == pytest.approx(expected, rel=1e-3)
    assert beam.package.frequencies[:2] == pytest.approx(expected[:2], rel=5e-5)
