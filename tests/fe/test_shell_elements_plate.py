"""A square plate under uniform load against the double series of Mindlin's theory."""

import numpy as np
import pytest
from samples.shell_element_samples import (
    assembled,
    element_stiffness,
    grid,
    isotropic,
    ratios,
    solved,
)

from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.elements.plates.dst import SHEAR_RATIO_LIMIT
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles

NU = 0.3


def series(thickness: float) -> float:
    """100 w D / (q a^4) in the middle, edges simply supported with held tangential rotation."""
    m = np.arange(1, 400, 2)
    sign = np.where(m % 4 == 1, 1.0, -1.0)
    squares = np.pi**2 * (m[:, None] ** 2 + m**2)
    shear_flexibility = thickness**2 / (6 * (1 - NU) * 5 / 6)  # D / Ds
    terms = np.outer(sign, sign) * 16 / (np.pi**2 * np.outer(m, m))
    return float(100 * np.sum(terms * (1 + shear_flexibility * squares) / squares**2))


def deflection(n: int, thickness: float, plate: str, warp: float = 0.0) -> float:
    xy, cells = grid(n, warp)
    points = np.pad(xy, ((0, 0), (0, 1)))
    t = triangles(points, cells, np.array([1.0, 0, 0]))
    laminate = isotropic(thickness, NU)
    K = assembled(element_stiffness(t, laminate, Choice(plate)), cells, len(xy))
    load, known = np.zeros((len(xy), 6)), np.zeros((len(xy), 6), dtype=bool)
    np.add.at(load[:, 2], cells, t.area[:, None] / 3)
    known[:, [0, 1, 5]] = True
    for axis, rotation in ((0, 3), (1, 4)):
        edge = (xy[:, axis] < 1e-9) | (xy[:, axis] > 1 - 1e-9)
        known[edge, 2] = known[edge, rotation] = True
    u = solved(K, np.zeros(load.size), known.ravel(), load.ravel()).reshape(-1, 6)
    middle = np.argmin(np.abs(xy - 0.5).sum(axis=1)) if not warp else (n // 2) * (n + 2)
    return float(100 * u[middle, 2] * laminate.D[0, 0])


@pytest.mark.parametrize(
    ("slenderness", "value"), [(5, 0.49043), (10, 0.42728), (100, 0.40645), (1e4, 0.40624)]
)
def test_series(slenderness, value) -> None:
    assert series(1 / slenderness) == pytest.approx(value, abs=6e-6)


@pytest.mark.one_end
@pytest.mark.parametrize(
    ("plate", "slenderness", "n"),
    [
        *[(plate, s, 16) for plate in ("dkmt", "dst") for s in (5, 10, 100, 1e4)],
        *[("dkt", s, 16) for s in (100, 1e4)],  # it has no shear
        *[("mitc3", s, 32) for s in (5, 10, 100, 1e4)],  # linear rotations: half the mesh size
    ],
)
def test_deflection(plate, slenderness, n) -> None:
    exact = series(1 / slenderness)
    assert deflection(n, 1 / slenderness, plate) == pytest.approx(exact, rel=5e-3)


@pytest.mark.one_end
@pytest.mark.parametrize("slenderness", [5, 100, 1e4])
def test_dkmt_converges_on_irregular_meshes(slenderness) -> None:
    errors = [
        deflection(n, 1 / slenderness, "dkmt", warp=0.25) / series(1 / slenderness) - 1
        for n in (8, 16, 32)
    ]
    assert errors[2] == pytest.approx(0.0, abs=2e-3)
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (rates > 1.7).all()


def test_dst_does_not_converge_on_irregular_meshes() -> None:
    # With smaller triangles the plate is thicker against them: the criterion warns.
    errors = [abs(deflection(n, 0.2, "dst", warp=0.25) / series(0.2) - 1) for n in (16, 32)]
    assert errors[1] > 4e-3 > errors[0]
    xy, cells = grid(32, 0.25)
    t = triangles(np.pad(xy, ((0, 0), (0, 1))), cells, np.array([1.0, 0, 0]))
    laminate = isotropic(0.2, NU)
    assert ratios(t, laminate).min() > SHEAR_RATIO_LIMIT
