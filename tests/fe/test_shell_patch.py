"""Patch tests: a constant state given at the corners of an irregular patch appears inside it."""

import itertools

import numpy as np
import pytest
from samples.shell_element_samples import (
    MEMBRANES,
    PLATES,
    coupled,
    in_space,
    isotropic,
    nodal,
    patch,
    patch_error,
    ratios,
    state,
    turn,
)

from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.elements.plates.dst import SHEAR_RATIO_LIMIT
from plymotion.preprocess.shell.elements.single_cells import element_resultants, element_strains
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles

STRAIN = np.array([1.0, -0.4, 0.7])
CURVATURE = np.array([0.8, 1.0, -0.5])
# Every pair but "cst" with "none", where tz has no stiffness at all.
DRILLINGS = ("auto", "tie", "fictitious", "none")
HELD = [p for p in itertools.product(MEMBRANES, DRILLINGS) if p != ("cst", "none")]
NONE = np.zeros(3)
EXACT_PLATES = [plate for plate in PLATES if plate != "dst"]


@pytest.mark.parametrize(("membrane", "drilling"), HELD)
@pytest.mark.parametrize("laminate", [isotropic(0.1), coupled(0.1)], ids=["plain", "coupled"])
def test_constant_strain(laminate, membrane, drilling) -> None:
    choice = Choice(membrane=membrane, drilling=drilling, drilling_factor=0.1)
    assert patch_error(laminate, choice, STRAIN, NONE) < 1e-12


@pytest.mark.parametrize("thickness", [1e-3, 0.1, 1.0])
@pytest.mark.parametrize("plate", EXACT_PLATES)
def test_constant_curvature(plate, thickness) -> None:
    choice = Choice(plate=plate)
    assert patch_error(isotropic(thickness), choice, NONE, CURVATURE, np.eye(3)) < 1e-12


@pytest.mark.parametrize("plate", EXACT_PLATES)
def test_constant_curvature_askew_in_space(plate) -> None:
    # Askew axes mix stretching with bending, (1/h)^2 as large: round-off allows no thinner plate.
    assert patch_error(isotropic(0.1), Choice(plate=plate), NONE, CURVATURE) < 1e-12


@pytest.mark.parametrize("membrane", MEMBRANES)
@pytest.mark.parametrize("plate", EXACT_PLATES)
def test_strain_and_curvature_of_a_coupled_laminate(plate, membrane) -> None:
    choice = Choice(plate=plate, membrane=membrane)
    assert patch_error(coupled(0.1), choice, STRAIN, CURVATURE) < 1e-12


def test_dst_passes_where_it_is_thin() -> None:
    laminate = isotropic(1e-3)
    assert patch_error(laminate, Choice(plate="dst"), NONE, CURVATURE) < 1e-6
    assert patch_ratio(laminate) < SHEAR_RATIO_LIMIT


def test_dst_warns_where_it_fails() -> None:
    # The rotations on a side differ between its two triangles once shear matters over the side
    # (Batoz and Lardeur 1989 name it): the error is the element's, so the criterion has to see it.
    laminate = isotropic(0.1)
    assert 1e-3 < patch_error(laminate, Choice(plate="dst"), NONE, CURVATURE) < 3e-3
    assert patch_ratio(laminate) > SHEAR_RATIO_LIMIT


def test_error_of_dst_stays_below_a_fiftieth_of_its_criterion() -> None:
    for thickness in (1e-3, 3e-3, 0.01, 0.03, 0.1):
        laminate = isotropic(thickness)
        error = patch_error(laminate, Choice(plate="dst"), NONE, CURVATURE)
        assert 1e-3 * patch_ratio(laminate) < error < 2e-2 * patch_ratio(laminate)


def patch_ratio(laminate) -> float:
    xy, cells = patch()
    t = triangles(in_space(xy, np.eye(3)), cells, np.array([1.0, 0, 0]))
    return float(ratios(t, laminate).max())


@pytest.mark.parametrize("membrane", MEMBRANES)
@pytest.mark.parametrize("plate", PLATES)
def test_resultants_of_a_constant_state(plate, membrane) -> None:
    # Paper: Eq. (27), Eq. (28)
    xy, cells = patch()
    A_GE = turn(4)
    laminate = coupled(0.1)
    t = triangles(in_space(xy, A_GE), cells, A_GE[:, 0])
    states = [(STRAIN, NONE), (NONE, CURVATURE), (STRAIN, CURVATURE)]
    u = np.concatenate([nodal(state(xy, e, k, A_GE), cells) for e, k in states], axis=2)
    choice = Choice(plate=plate, membrane=membrane)
    strains = element_strains(t, laminate, choice, u)
    resultants = element_resultants(t, laminate, choice, u)
    for i, (e, k) in enumerate(states):
        exact = np.concatenate([e, k, np.zeros(2)])
        assert np.allclose(strains[:, :, i], exact, atol=1e-12)
        N, M = laminate.A @ e + laminate.B @ k, laminate.B @ e + laminate.D @ k
        assert np.allclose(resultants[:, :3, i], N, rtol=1e-12, atol=1e-12 * abs(N).max())
        assert np.allclose(resultants[:, 3:6, i], M, rtol=1e-12, atol=1e-12 * abs(M).max())
        assert np.allclose(resultants[:, 6:, i], 0.0, atol=1e-12 * abs(laminate.Ds).max())


def test_constant_shear_of_mitc3() -> None:
    xy, cells = patch()
    A_GE = turn(4)
    t = triangles(in_space(xy, A_GE), cells, A_GE[:, 0])
    gamma = np.array([0.3, -0.8])
    u = np.zeros((len(xy), 6))
    u[:, :3] = (xy @ gamma)[:, None] * A_GE[:, 2]
    strains = element_strains(t, coupled(0.1), Choice(plate="mitc3"), nodal(u, cells))
    assert np.allclose(strains[:, 6:, 0], gamma, atol=1e-13)
