"""Stiffness and shear correction against the tables of tests/reference/laminates."""

import numpy as np
import pytest
from samples.laminate_samples import reference, reference_laminates

from plymotion.preprocess.laminate.stiffness import (
    Laminate,
    laminate_stiffness,
    shear_factors,
    uncorrected,
)

TABLES = reference("laminate.toml")
LAMINATES = reference_laminates()
DIGITS_OF_FACTORS = 0.5e-6  # they are given to six digits


def test_every_table_has_its_lay_up() -> None:
    theory = {name for name in TABLES["shear_correction_theory"] if name.startswith("E40")}
    assert set(TABLES["laminate"]) | theory == set(LAMINATES)


@pytest.mark.parametrize("name", sorted(TABLES["laminate"]))
def test_stiffness(name: str) -> None:
    """To 1e-9 of the largest stiffness of the kind, h^n max A."""
    table, laminate = TABLES["laminate"][name], LAMINATES[name]
    ours = laminate_stiffness(laminate, "energy-2x2")
    size = np.max(table["A"])
    for n, key in enumerate("ABD"):
        np.testing.assert_allclose(
            getattr(ours, key), table[key], rtol=0, atol=1e-9 * size * ours.thickness**n
        )
    shear = np.max(table["Ds_uncorrected"])
    np.testing.assert_allclose(
        uncorrected(laminate), table["Ds_uncorrected"], rtol=0, atol=1e-9 * shear
    )
    np.testing.assert_allclose(ours.Ds, table["Ds_energy2x2"], rtol=0, atol=1e-9 * shear)


@pytest.mark.parametrize("name", sorted(TABLES["laminate"]))
def test_shear_factors(name: str) -> None:
    table, laminate = TABLES["laminate"][name], LAMINATES[name]
    for method, key in (("energy-1d", "k_vlachoutsis"), ("energy-2x2", "k_energy2x2_diag")):
        np.testing.assert_allclose(
            shear_factors(laminate, method), table[key], rtol=0, atol=1.0001 * DIGITS_OF_FACTORS
        )


@pytest.mark.parametrize("name", ["E40_0_90_0", "E40_0_90_90_0"])
def test_shear_factors_of_the_stiffer_ply(name: str) -> None:
    table = TABLES["shear_correction_theory"][name]
    for method, key in (("energy-1d", "vlachoutsis"), ("energy-2x2", "energy2x2")):
        np.testing.assert_allclose(
            shear_factors(LAMINATES[name], method), table[key], rtol=0, atol=DIGITS_OF_FACTORS
        )


def test_homogeneous_plates_have_five_sixths() -> None:
    expected = TABLES["shear_correction_theory"]["homogeneous"]
    for name in ("box_0", "box_15", "m25_30"):
        for method in ("energy-1d", "energy-2x2"):
            np.testing.assert_allclose(shear_factors(LAMINATES[name], method), expected, rtol=1e-13)
    np.testing.assert_allclose(  # by the 1-D method [a/-a] is homogeneous as well
        shear_factors(LAMINATES["m25_45_m45"], "energy-1d"), expected, rtol=1e-13
    )


@pytest.mark.parametrize("contrast", [10, 100, 1000])
def test_isotropic_sandwich(contrast: int) -> None:
    """Faces of 0.1 on a core of 0.8; both methods agree there."""
    from plymotion.preprocess.laminate.stiffness import Lamina
    from plymotion.solver.package.common.materials import isotropic

    table = TABLES["shear_correction_theory"]["isotropic_sandwich_01_08_01"]
    face, core = isotropic(float(contrast), 0.3, 1.0), isotropic(1.0, 0.3, 1.0)
    sandwich = Laminate((Lamina(face, 0, 0.1), Lamina(core, 0, 0.8), Lamina(face, 0, 0.1)))
    expected = table[f"face_over_core_{contrast}"]
    for method in ("energy-1d", "energy-2x2"):
        np.testing.assert_allclose(
            shear_factors(sandwich, method), expected, rtol=0, atol=DIGITS_OF_FACTORS
        )
