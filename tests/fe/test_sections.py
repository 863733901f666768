"""Sections against published and closed-form values, entry by entry."""

import tomllib
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section import SectionError, analyse

FOLDER = Path(__file__).resolve().parent.parent / "reference" / "sections"
FILES = sorted(path for path in FOLDER.glob("[0-9]*.toml"))
CLOSED_FORMS = tomllib.loads((FOLDER / "closed_forms.toml").read_text(encoding="utf-8"))

ALUMINIUM = {"kind": "isotropic", "E": 73e9, "nu": 0.33, "rho": 2700.0}


def spec_of(reference: dict[str, Any]) -> dict[str, Any]:
    """The section description of a reference file."""
    geometry, material = reference["geometry"], reference["material"]
    if "E" in material:
        table = {"kind": "isotropic", **{key: material[key] for key in ("E", "nu", "rho")}}
    else:
        table = {"kind": "orthotropic", **material}
    if geometry["type"] == "rectangle":
        shape = {"shape": "rectangle", "width": geometry["b"], "height": geometry["h"]}
    else:
        shape = {"shape": "ellipse", "radius_2": geometry["a2"], "radius_3": geometry["a3"]}
    angle = reference.get("layup", {}).get("theta3", 0.0)
    return {"name": reference["id"], **shape, "material": table, "ply_angle_deg": angle}


def scaled(difference: Any, K: Any) -> Any:
    """Error of each entry in units of sqrt(Kii Kjj)."""
    size = np.sqrt(np.diag(K))
    return np.abs(difference) / np.outer(size, size)


def test_reference_files_are_there() -> None:
    assert [path.name[:3] for path in FILES] == ["01_", "02_", "03_", "04_", "05_", "09b", "15_"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_reference(path: Path, record: Callable[[str, Any], None]) -> None:
    reference = tomllib.loads(path.read_text(encoding="utf-8"))
    verified = reference["verified"]
    result = analyse(spec_of(reference))
    expected = np.array(verified["K"])
    # the reference is as exact as its last refinement changed it; two codes cannot agree better
    tolerance = max(verified["change_between_last_two_levels"], 1e-4)
    assert tolerance < 1e-3
    assert scaled(result.K - expected, expected).max() < tolerance

    moments = verified["mass_moments"]
    diagonal = [verified["mass_per_length"]] * 3 + [moments["i11"], moments["i22"], moments["i33"]]
    assert np.diag(result.M) == pytest.approx(diagonal, rel=5e-5)
    length = np.sqrt(result.M[3, 3] / result.M[0, 0])
    for centre in (result.shear_centre, result.tension_centre, result.mass_centre):
        assert np.abs(centre).max() < 1e-9 * length
    record(f"section/{reference['id']}/K", result.K)
    record(f"section/{reference['id']}/M", result.M)


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_form(name: str, record: Callable[[str, Any], None]) -> None:
    case = CLOSED_FORMS[name]
    sizes = {key: case[key] for key in ("width", "height", "radius_2", "radius_3") if key in case}
    material = {"kind": "isotropic", "E": 1.0, "nu": case["nu"], "rho": 1.0}
    result = analyse({"shape": case["shape"], **sizes, "material": material})
    G = 0.5 / (1.0 + case["nu"])
    if "k" in case:
        area = pi if case["shape"] == "ellipse" else 1.0
        values, expected = np.diag(result.K)[1:3] / (G * area), case["k"]
    else:
        values, expected = result.K[3, 3] / G, case["J"]
    assert values == pytest.approx(expected, rel=case["tolerance"])
    record(f"section/closed form/{name}", values)


def test_free_strip_is_classical_lamination() -> None:
    """The off-axis strip's compliance is that of laminate theory, an independent route."""
    path = FOLDER / "15_composite_strip_30.toml"
    reference = tomllib.loads(path.read_text(encoding="utf-8"))
    S = np.linalg.inv(analyse(spec_of(reference)).K)
    assert 1 / S[0, 0] == pytest.approx(reference["analytic"]["EA_free_strip"], rel=1e-6)
    assert 1 / S[4, 4] == pytest.approx(reference["analytic"]["EI2_free_strip"], rel=1e-6)


def test_mass_of_a_rectangle() -> None:
    M = analyse({"shape": "rectangle", "width": 0.06, "height": 0.015, "material": ALUMINIUM}).M
    m, b, h = 2700.0 * 0.06 * 0.015, 0.06, 0.015
    expected = np.diag([m, m, m, m * (b**2 + h**2) / 12, m * h**2 / 12, m * b**2 / 12])
    assert np.abs(M - expected).max() < 1e-12 * m


@pytest.mark.parametrize(("nu", "quantity"), [(0.3, "J"), (0.3, "k")])
def test_order_of_convergence(nu: float, quantity: str) -> None:
    """Energies of degree-2 fields converge with order 4; the finest error is small as well."""
    exact = {"J": CLOSED_FORMS["square_torsion"]["J"], "k": CLOSED_FORMS["square_k_nu03"]["k"]}
    errors = []
    for n in (2, 4, 8):
        K = analyse(
            {
                "shape": "rectangle",
                "width": 1.0,
                "height": 1.0,
                "elements": [n, n],
                "grading": 0.0,
                "material": {"kind": "isotropic", "E": 1.0, "nu": nu, "rho": 1.0},
            }
        ).K
        G = 0.5 / (1 + nu)
        value = K[3, 3] / G if quantity == "J" else K[1, 1] / G
        errors.append(abs(value / exact[quantity] - 1))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.5)
    assert errors[-1] < 1e-4


def test_default_mesh_is_converged(record: Callable[[str, Any], None]) -> None:
    """Twice as many elements change no entry of an off-axis ply by more than 1e-4."""
    reference = tomllib.loads((FOLDER / "15_composite_strip_30.toml").read_text(encoding="utf-8"))
    spec = spec_of(reference)
    coarse, fine = analyse(spec).K, analyse({**spec, "elements": [112, 20]}).K
    assert scaled(coarse - fine, fine).max() < 1e-4
    record("section/strip_fine/K", fine)


def test_turning_a_section_swaps_its_axes() -> None:
    flat = {"shape": "rectangle", "width": 0.06, "height": 0.015, "material": ALUMINIUM}
    upright = {**flat, "width": 0.015, "height": 0.06}
    order = [0, 2, 1, 3, 5, 4]
    K = analyse(flat).K
    assert scaled(analyse(upright).K[np.ix_(order, order)] - K, K).max() < 1e-10


def test_opposite_ply_angle_turns_the_couplings() -> None:
    reference = tomllib.loads(
        (FOLDER / "09b_ortho_square_becas_s3_22.5.toml").read_text(encoding="utf-8")
    )
    spec = spec_of(reference)
    plus, minus = analyse(spec).K, analyse({**spec, "ply_angle_deg": -22.5}).K
    mirror = np.diag([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # x2 -> -x2
    assert plus[0, 1] > 0.1 * np.sqrt(plus[0, 0] * plus[1, 1])
    assert scaled(mirror @ minus @ mirror - plus, plus).max() < 1e-10


def test_one_mesh_serves_every_material() -> None:
    """Nothing of one material stays behind in the kept mesh, forms and factorisation."""
    spec = {"shape": "rectangle", "width": 0.05, "height": 0.02, "material": ALUMINIUM}
    reference = tomllib.loads((FOLDER / "15_composite_strip_30.toml").read_text(encoding="utf-8"))
    first = analyse(spec)
    other = analyse({**spec, "material": spec_of(reference)["material"], "ply_angle_deg": 30.0})
    again = analyse(spec)
    assert scaled(other.K - first.K, first.K).max() > 0.1
    assert np.array_equal(again.K, first.K)
    assert np.array_equal(again.M, first.M)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shape": "rectangel"}, r"arm\.shape = 'rectangel'.*did you mean 'rectangle'"),
        ({"height": -0.015}, r"arm\.height = -0.015: expected a length above 0"),
        ({"width": "wide"}, r"arm\.width = 'wide'"),
        ({"heigth": 0.1}, r"arm\.heigth: unknown key.*did you mean 'height'"),
        ({"radius_2": 0.1}, r"arm\.radius_2: unknown key of a rectangle"),
        ({"elements": [4, 0]}, r"arm\.elements = \[4, 0\]: expected two whole numbers"),
        ({"grading": 2.0}, r"arm\.grading = 2.0: expected a number from 0 to 1"),
        ({"ply_angle_deg": "30"}, r"arm\.ply_angle_deg = '30': expected an angle"),
    ],
)
def test_wrong_description(change: dict[str, Any], message: str) -> None:
    spec = {"shape": "rectangle", "width": 0.06, "height": 0.015, "material": ALUMINIUM}
    with pytest.raises(SectionError, match=message):
        analyse({**spec, **change}, where="arm")
