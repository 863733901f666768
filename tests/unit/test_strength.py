"""Failure criteria: worked examples, uniaxial limits, rays, invariances; the strength table."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from plymotion.solver.package import read_package
from plymotion.solver.package.common.materials import (
    MaterialError,
    PlyStrength,
    YieldStrength,
    bond,
    read_strength,
)
from plymotion.solver.strength import CRITERIA, Criterion, criteria_of
from plymotion.solver.strength.criteria.contract import exposure
from plymotion.solver.strength.criteria.hashin import hashin
from plymotion.solver.strength.criteria.max_stress import max_stress
from plymotion.solver.strength.criteria.tsai_hill import tsai_hill
from plymotion.solver.strength.criteria.tsai_wu import tsai_wu
from plymotion.solver.strength.criteria.von_mises import von_mises
from plymotion.solver.strength.search import Highest, PeakSearch
from plymotion.solver.strength.weakest_plies import BeamSearch

MPa = 1e6
# Graphite/epoxy of A. K. Kaw, Mechanics of Composite Materials, 2nd ed., Table 2.1.
KAW_TABLE = {"Xt": 1500e6, "Xc": 1500e6, "Yt": 40e6, "Yc": 246e6, "S12": 68e6}
KAW = read_strength(KAW_TABLE, "orthotropic", "kaw")
# A ply whose strengths all differ, S23 above Yt / 2.
PLY = PlyStrength(1500e6, 1200e6, 50e6, 200e6, 40e6, 260e6, 70e6, 60e6, 75e6)
# Equal in 2 and 3: results must not depend on a rotation of these axes about the fibre.
S23_ROUND = math.sqrt(50e6 * 200e6 / 3.0)  # Tsai-Wu's shear strength for F23 = -1/2 F22
ROUND = PlyStrength(1500e6, 1200e6, 50e6, 200e6, 50e6, 200e6, 70e6, 70e6, S23_ROUND)

names = pytest.mark.parametrize("criterion", criteria_of(PLY), ids=lambda c: c.name)
stresses = st.tuples(*(st.floats(-1.0, 1.0) for _ in range(6))).map(
    lambda s: np.array(s) * [2000e6, 100e6, 100e6, 80e6, 80e6, 80e6]
)


def kaw_stress() -> np.ndarray:
    """Sx = 2 MPa, Sy = -3 MPa, Txy = 4 MPa on a 60 deg lamina, in its axes (Kaw, section 2.8)."""
    c, s = math.cos(math.radians(60.0)), math.sin(math.radians(60.0))
    A_BM = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.linalg.solve(bond(A_BM), np.array([2.0, -3.0, 0.0, 0.0, 0.0, 4.0]) * MPa)


def test_stress_of_the_worked_example() -> None:
    assert kaw_stress() / MPa == pytest.approx([1.714, -2.714, 0, 0, 0, -4.165], abs=5e-4)


@pytest.mark.parametrize(
    ("criterion", "factor", "mode"),
    [
        # 68 / 4.165
        (max_stress, 16.33, "12 shear"),
        # 1 / sqrt(1.306e-6 + 2.068e-6 + 121.73e-6 + 3751.6e-6), each strength by its sign
        (tsai_hill, 16.06, "12 shear"),
        # a = 4.5327e-3, b = -5.6817e-2: (5.6817e-2 + sqrt(b^2 + 4 a)) / (2 a)
        (tsai_wu, 22.39, "12 shear"),
        # fibre: 1 / sqrt((1.714/1500)^2 + (4.165/68)^2)
        (hashin, 16.32, "fibre tension"),
    ],
)
def test_worked_example_of_a_lamina(criterion: Any, factor: float, mode: str) -> None:
    """Factors as Kaw prints them for the first three (section 2.8), by hand for Hashin."""
    verdict = criterion(kaw_stress(), KAW)
    assert float(verdict.ratio) == pytest.approx(factor, abs=6e-3)
    assert verdict.modes[int(verdict.mode)] == mode


def test_matrix_compression_of_hashin_by_hand() -> None:
    """s22 = -100, s12 = 50 MPa: (s/(2 S23))^2 + (s23^2 - s22 s33)/S23^2 is (100/150)^2 here."""
    ply = PlyStrength(1500e6, 1200e6, 50e6, 200e6, 50e6, 200e6, 70e6, 70e6, 75e6)
    verdict = hashin(np.array([0, -100.0, 0, 0, 0, 50.0]) * MPa, ply)
    linear = ((200 / 150) ** 2 - 1) * -100 / 200  # -0.388889
    quadratic = (100 / 150) ** 2 + (50 / 70) ** 2  # 0.444444 + 0.510204
    expected = (-linear + math.sqrt(linear**2 + 4 * quadratic)) / (2 * quadratic)
    assert float(verdict.ratio) == pytest.approx(expected, rel=1e-12)
    assert expected == pytest.approx(1.247, abs=1e-3)
    assert float(verdict.index) == pytest.approx(linear + quadratic, rel=1e-12)
    assert verdict.modes[int(verdict.mode)] == "matrix compression"


UNIAXIAL = [
    (0, 1, "Xt"),
    (0, -1, "Xc"),
    (1, 1, "Yt"),
    (1, -1, "Yc"),
    (2, 1, "Zt"),
    (2, -1, "Zc"),
    (3, 1, "S23"),
    (3, -1, "S23"),
    (4, 1, "S13"),
    (5, 1, "S12"),
    (5, -1, "S12"),
]


@names
@pytest.mark.parametrize(("component", "sign", "key"), UNIAXIAL)
def test_one_stress_alone_fails_at_its_strength(
    criterion: Criterion, component: int, sign: int, key: str
) -> None:
    stress = np.zeros(6)
    stress[component] = sign * 1e6
    # Hashin's criterion has one matrix: strengths normal to the ply equal those across it.
    key = key.replace("Z", "Y") if criterion.name == "hashin" else key
    verdict = criterion.assess(stress, PLY)
    assert float(verdict.ratio) == pytest.approx(getattr(PLY, key) / 1e6, rel=1e-12)


def test_modes_name_what_fails() -> None:
    stress = np.zeros((6, 6))
    np.fill_diagonal(stress, -1e9)
    found = [max_stress(stress, PLY).modes[m] for m in max_stress(stress, PLY).mode]
    assert found == [
        "11 compression",
        "22 compression",
        "33 compression",
        "23 shear",
        "13 shear",
        "12 shear",
    ]
    for criterion in (tsai_hill, tsai_wu):
        verdict = criterion(stress, PLY)
        assert [verdict.modes[m] for m in verdict.mode] == [
            "fibre",
            "matrix",
            "through thickness",
            "23 shear",
            "13 shear",
            "12 shear",
        ]
    verdict = hashin(stress, PLY)
    assert [verdict.modes[m] for m in verdict.mode] == [
        "fibre compression",
        "matrix compression",
        "matrix compression",
        *["matrix tension"] * 3,
    ]


@names
@given(stress=stresses)
def test_index_is_one_at_failure(criterion: Criterion, stress: np.ndarray) -> None:
    ratio = float(criterion.assess(stress, PLY).ratio)
    assume(ratio < 1e6)
    at_failure = criterion.assess(ratio * stress, PLY)
    assert float(at_failure.index) == pytest.approx(1.0, rel=1e-9)
    assert float(at_failure.ratio) == pytest.approx(1.0, rel=1e-9)


@names
@given(stress=stresses, factor=st.floats(1e-3, 1e3))
def test_exposure_is_proportional_to_the_stress(
    criterion: Criterion, stress: np.ndarray, factor: float
) -> None:
    one = float(criterion.assess(stress, PLY).exposure)
    assert float(criterion.assess(factor * stress, PLY).exposure) == pytest.approx(
        factor * one, rel=1e-9, abs=1e-15
    )


@names
@given(stress=stresses, flip=st.sampled_from([(3, 4), (3, 5), (4, 5)]))
def test_half_turns_of_the_ply_change_nothing(
    criterion: Criterion, stress: np.ndarray, flip: tuple[int, int]
) -> None:
    """A half turn about an axis of the ply changes the signs of two shear stresses."""
    turned = stress.copy()
    turned[list(flip)] *= -1.0
    expected = float(criterion.assess(stress, PLY).exposure)
    assert float(criterion.assess(turned, PLY).exposure) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("criterion", [tsai_wu, hashin], ids=["tsai-wu", "hashin"])
@given(stress=stresses, angle=st.floats(0.0, 2.0 * math.pi))
def test_turn_about_the_fibre_changes_nothing(
    criterion: Any, stress: np.ndarray, angle: float
) -> None:
    """For a ply with equal 2 and 3, these two depend on invariants of rotations about its fibre."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    expected = float(criterion(stress, ROUND).exposure)
    found = float(criterion(bond(turn) @ stress, ROUND).exposure)
    # The conditions of tension and compression meet, with a jump, where s22 + s33 changes sign.
    assume(abs(stress[1] + stress[2]) > 1.0)
    assert found == pytest.approx(expected, rel=1e-7, abs=1e-12)


@given(stress=stresses, seed=st.integers(0, 10**6))
def test_von_mises_in_any_axes(stress: np.ndarray, seed: int) -> None:
    Q, R = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    Q = Q * np.sign(np.diag(R))
    Q = Q * np.linalg.det(Q)
    steel = YieldStrength(355e6)
    expected = float(von_mises(stress, steel).exposure)
    pressure = np.array([1e8, 1e8, 1e8, 0, 0, 0])
    found = float(von_mises(bond(Q) @ stress + pressure, steel).exposure)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-7)


def test_von_mises_limits() -> None:
    steel = YieldStrength(355e6)
    states = np.array([[355e6, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 355e6 / math.sqrt(3.0)]])
    assert von_mises(states, steel).ratio == pytest.approx([1.0, 1.0], rel=1e-12)
    assert von_mises(np.zeros(6), steel).ratio == math.inf


def test_tsai_wu_of_equal_strengths_is_von_mises() -> None:
    """F12_star = -0.5, X = Y = Z = sqrt(3) S."""
    shear = 355e6 / math.sqrt(3.0)
    ply = PlyStrength(*[355e6] * 6, *[shear] * 3)
    stress = np.random.default_rng(0).normal(size=(200, 6)) * 1e8
    expected = von_mises(stress, YieldStrength(355e6)).ratio
    assert tsai_wu(stress, ply).ratio == pytest.approx(expected, rel=1e-9)
    assert tsai_hill(stress, ply).ratio == pytest.approx(expected, rel=1e-9)


def test_interaction_of_tsai_wu() -> None:
    """s11 = 100, s22 = 10 MPa, term by term."""
    ply = read_strength({**KAW_TABLE, "F12_star": 0.2}, "orthotropic", "k")
    s = np.array([100e6, 10e6, 0, 0, 0, 0])
    F11, F22 = 1 / 1500e6**2, 1 / (40e6 * 246e6)
    F12 = 0.2 * math.sqrt(F11 * F22)
    expected = F11 * 1e16 + F22 * 1e14 + 2 * F12 * 1e15 + (1 / 40e6 - 1 / 246e6) * 1e7
    assert float(tsai_wu(s, ply).index) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("criterion", [tsai_hill, tsai_wu, max_stress])
@pytest.mark.parametrize("component", range(3))
def test_left_hand_side_is_continuous_where_a_stress_changes_sign(
    criterion: Any, component: int
) -> None:
    stress = np.random.default_rng(1).normal(size=(50, 6)) * [500e6, 30e6, 30e6, 20e6, 20e6, 20e6]
    below, above = stress.copy(), stress.copy()
    below[:, component], above[:, component] = -1e-3, 1e-3
    found = criterion(below, PLY).exposure - criterion(above, PLY).exposure
    assert np.abs(found).max() < 1e-9


def test_no_stress_never_fails() -> None:
    for criterion in CRITERIA.values():
        strength = PLY if criterion.strength is PlyStrength else YieldStrength(1e6)
        verdict = criterion.assess(np.zeros((2, 6)), strength)
        assert np.all(np.isinf(verdict.ratio))
        assert np.all(verdict.index == 0.0)


def test_ray_without_failure() -> None:
    # a R^2 + b R = 1 has no positive root; two roots; a cancelling one
    a, b = np.array([-1.0, -1.0, 0.0, 1e-18, -0.09]), np.array([-1.0, 1.0, -1.0, -1.0, 1.0])
    found = exposure(a, b)
    assert found[:3] == pytest.approx([0.0, 0.0, 0.0])
    assert found[3] == pytest.approx(1e-18, rel=1e-12)
    assert 1.0 / found[4] == pytest.approx((1 - math.sqrt(1 - 0.36)) / 0.18, rel=1e-12)


@names
@given(one=stresses, other=stresses)
def test_bound_is_above_the_exposure_and_convex(
    criterion: Criterion, one: np.ndarray, other: np.ndarray
) -> None:
    for ply in (PLY, ROUND, KAW, PlyStrength(*[1e8] * 8, 2e7)):  # the last: S23 < Yt / 2
        bounds = [float(criterion.bound(s, ply)) for s in (one, other, one + other)]
        assert bounds[0] >= float(criterion.assess(one, ply).exposure) * (1 - 1e-12)
        assert bounds[2] <= (bounds[0] + bounds[1]) * (1 + 1e-9) + 1e-12


@names
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), instants=st.integers(1, 70), points=st.integers(1, 40))
def test_search_finds_what_looking_everywhere_finds(
    criterion: Criterion, seed: int, instants: int, points: int
) -> None:
    rng = np.random.default_rng(seed)
    operators = rng.normal(size=(points, 6, 6)) * np.array([20, 1, 0.5, 0.5, 1, 1.0])[:, None] * MPa
    F = rng.normal(size=(6, 1)) * np.sin(rng.normal(size=(6, 1)) * np.arange(instants) / 9.0)
    stress = np.einsum("pij,jt->pti", operators, F)
    everywhere = criterion.assess(stress, PLY).exposure
    group = np.arange(points) % min(points, 3)
    case = np.arange(instants) % min(instants, 4)
    groups, cases = Highest(np.zeros(group.max() + 1)), Highest(np.zeros(case.max() + 1))
    search = PeakSearch(operators, criterion, PLY, group)
    search.peaks(F, case, groups, cases)
    parts = Highest(np.zeros(groups.exposure.size)), Highest(np.zeros(cases.exposure.size))
    for some in (slice(0, instants // 2), slice(instants // 2, None)):  # one after the other
        search.peaks(F[:, some], case[some], *parts)
    np.testing.assert_allclose(parts[0].exposure, groups.exposure, rtol=1e-12)
    np.testing.assert_allclose(parts[1].exposure, cases.exposure, rtol=1e-12)
    for sets, own in ((groups, group[:, None]), (cases, case)):
        for k, highest in enumerate(sets.exposure):
            assert highest == pytest.approx(np.where(own == k, everywhere, 0.0).max(), rel=1e-12)
            there = everywhere[sets.point[k], sets.column[k]] if sets.point[k] >= 0 else 0.0
            assert there == pytest.approx(highest, rel=1e-9)


def test_beam_is_searched_with_few_evaluations(
    repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bounds exclude 98 % of 1824 points at 18 stations and 51 times, under four criteria."""
    package = read_package(repository / "tests/packages/actuated-beam/beam.layup-1.vtkhdf")
    assert package.recovery is not None
    stations, points = package.recovery.station_x.size, len(package.sections[0].recovery.points)
    t, evaluated, own = np.linspace(0.0, 1.0, 51), 0, PeakSearch.exposures

    def counted(search: PeakSearch, F: np.ndarray, at: np.ndarray, columns: np.ndarray) -> Any:
        nonlocal evaluated
        evaluated += at.size
        return own(search, F, at, columns)

    monkeypatch.setattr(PeakSearch, "exposures", counted)
    rates = np.arange(1, package.n_mode + 1)
    BeamSearch(package).take(t, np.sin(7.0 * t[:, None] * rates) / rates**3)
    assert 0 < evaluated < 0.03 * 4 * stations * points * t.size


def test_defaults_and_their_reasons() -> None:
    assert isinstance(KAW, PlyStrength)
    assert (KAW.Zt, KAW.Zc, KAW.S13, KAW.F12_star) == (KAW.Yt, KAW.Yc, KAW.S12, -0.5)
    assert pytest.approx(0.378, abs=2e-3) == KAW.S23 / KAW.Yc  # Davila, Camanho and Rose 2005
    given_all = read_strength({**KAW_TABLE, "S23": 50e6, "Zt": 30e6}, "orthotropic", "k")
    assert isinstance(given_all, PlyStrength)
    assert (given_all.S23, given_all.Zt) == (50e6, 30e6)
    assert read_strength({"yield_stress": 1}, "isotropic", "k") == YieldStrength(1.0)


@pytest.mark.parametrize(
    ("table", "kind", "message"),
    [
        ({**KAW_TABLE, "Xs": 1e6}, "orthotropic", r"cfrp\.strength\.Xs: unknown strength of"),
        ({**KAW_TABLE, "F12_stra": 1}, "orthotropic", r"F12_stra: .*did you mean 'F12_star'"),
        ({k: v for k, v in KAW_TABLE.items() if k != "Yc"}, "orthotropic", r"Yc: missing, exp"),
        ({**KAW_TABLE, "Xc": -1500e6}, "orthotropic", r"Xc = -1.5e\+09 Pa: expected a value above"),
        ({**KAW_TABLE, "S12": "68"}, "orthotropic", r"S12 = '68': expected a number \[Pa\]"),
        ({**KAW_TABLE, "S12": math.nan}, "orthotropic", r"S12 = nan: expected a number"),
        ({**KAW_TABLE, "S12": True}, "orthotropic", r"S12 = True: expected a number"),
        ({**KAW_TABLE, "F12_star": -0.6}, "orthotropic", r"F12_star = -0.6: expected -0.5 <= F12_"),
        ({**KAW_TABLE, "F12_star": 1.0}, "orthotropic", r"F12_star = 1: expected -0.5 <= F12"),
        ({}, "isotropic", r"yield_stress: missing, expected a stress"),
        ({"Xt": 1.0}, "isotropic", r"Xt: unknown strength of an isotropic material; expected"),
        (3.0, "isotropic", r"expected a table of strengths, got 3.0"),
        ({}, "granular", r"a material of kind 'granular' has no strengths"),
    ],
)
def test_wrong_tables(table: Any, kind: str, message: str) -> None:
    with pytest.raises(MaterialError, match=message) as error:
        read_strength(table, kind, "case.toml: materials.cfrp.strength")
    assert str(error.value).startswith("case.toml: materials.cfrp.strength")
