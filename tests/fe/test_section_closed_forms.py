"""Sections with exact solutions, to 1e-6; rates of convergence; symmetries."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.package.section.section_schema import SectionFile

FOLDER = Path(__file__).resolve().parent.parent / "reference" / "sections"
CLOSED_FORMS = tomllib.loads((FOLDER / "closed_forms.toml").read_text(encoding="utf-8"))

ALUMINIUM = {"kind": "isotropic", "E": 73e9, "nu": 0.33, "rho": 2700.0}
CARBON = {
    "kind": "orthotropic",
    **{"E1": 142e9, "E2": 9.8e9, "E3": 9.8e9, "G12": 6.0e9, "G13": 6.0e9, "G23": 4.8e9},
    **{"nu12": 0.42, "nu13": 0.42, "nu23": 0.42, "rho": 1600.0},
}


def solved(
    shape: str, sizes: dict[str, float], material: dict[str, Any], angle: float = 0.0, **mesh: Any
) -> SectionFile:
    """A section of one region and one material."""
    degree = {"degree": mesh.pop("degree")} if "degree" in mesh else {}
    expanded = expand(shape, {**sizes, **mesh})
    region = "wall" if shape == "tube" else "section"
    direction = {"circle": [0.0, 0.0]} if shape == "tube" else {"vector": [1.0, 0.0]}
    spec = {
        "name": shape,
        "convention": "contour",
        "mesh": {**expanded, **degree},
        "materials": {"m": material},
        "regions": {
            region: {"plies": [{"material": "m", "angle_deg": angle}], "direction": direction}
        },
    }
    return analyse(spec, estimate=False)


def fine(shape: str) -> dict[str, Any]:
    """Meshes on which a closed form is met to 1e-6."""
    if shape == "ellipse":
        return {"elements_arc": 24, "elements_radial": 12}
    return {"elements_2": 24, "elements_3": 24, "degree": 3}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_form(name: str, record: Callable[[str, Any], None]) -> None:
    case = CLOSED_FORMS[name]
    sizes = {key: case[key] for key in ("width", "height", "radius_2", "radius_3") if key in case}
    material = {"kind": "isotropic", "E": 1.0, "nu": case["nu"], "rho": 1.0}
    K = solved(case["shape"], sizes, material, **fine(case["shape"])).K
    G = 0.5 / (1.0 + case["nu"])
    area = np.pi * sizes.get("radius_2", 0.0) * sizes.get("radius_3", 0.0) or 1.0
    if "k" in case:
        values, expected = np.diag(K)[1:3] / (G * area), case["k"]
    else:
        values, expected = np.diag(K)[3:4] / G, case["J"]
    assert values == pytest.approx(expected, rel=case["tolerance"])
    record(f"section/closed form/{name}", values)


def test_tube_is_exact() -> None:
    """EA, GJ and EI of a ring, to 1e-6."""
    ri, ro = 0.09, 0.1
    material = {"kind": "isotropic", "E": 100.0, "nu": 0.2, "rho": 1.0}
    K = solved("tube", {"outer_radius": ro, "wall": ro - ri}, material, density=2.0).K
    E, G = 100.0, 100.0 / 2.4
    area, inertia = np.pi * (ro**2 - ri**2), 0.25 * np.pi * (ro**4 - ri**4)
    exact = [E * area, 2 * G * inertia, E * inertia, E * inertia]
    assert np.diag(K)[[0, 3, 4, 5]] == pytest.approx(exact, rel=1e-6)


def test_mass_of_a_rectangle() -> None:
    M = solved("rectangle", {"width": 0.06, "height": 0.015}, ALUMINIUM).M
    m, b, h = 2700.0 * 0.06 * 0.015, 0.06, 0.015
    expected = np.diag([m, m, m, m * (b**2 + h**2) / 12, m * h**2 / 12, m * b**2 / 12])
    assert np.abs(M - expected).max() < 1e-12 * m


@pytest.mark.one_end
@pytest.mark.parametrize(("quantity", "degree"), [("J", 2), ("k", 2), ("J", 3)])
def test_order_of_convergence(quantity: str, degree: int) -> None:
    """Energies of degree-2 fields converge with order 4; the finest error is small as well.

    Degree 3 keeps order 4 in torsion: the corners of the square are no smoother than that.
    """
    exact = {"J": CLOSED_FORMS["square_torsion"]["J"], "k": CLOSED_FORMS["square_k_nu03"]["k"]}
    errors = []
    for n in (2, 4, 8):
        material = {"kind": "isotropic", "E": 1.0, "nu": 0.3, "rho": 1.0}
        mesh = {"elements_2": n, "elements_3": n, "grading": 0.0, "degree": degree}
        K = solved("rectangle", {"width": 1.0, "height": 1.0}, material, **mesh).K
        value = K[3, 3] * 2.6 if quantity == "J" else K[1, 1] * 2.6
        errors.append(abs(value / exact[quantity] - 1))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.5)
    assert errors[-1] < 1e-4


def test_turning_a_section_swaps_its_axes() -> None:
    flat = solved("rectangle", {"width": 0.06, "height": 0.015}, ALUMINIUM).K
    upright = solved("rectangle", {"width": 0.015, "height": 0.06}, ALUMINIUM).K
    order = [0, 2, 1, 3, 5, 4]
    assert scaled(upright[np.ix_(order, order)] - flat, flat).max() < 1e-9


def test_opposite_ply_angle_turns_the_couplings() -> None:
    size = {"width": 0.03, "height": 0.02}
    plus = solved("rectangle", size, CARBON, 22.5).K
    minus = solved("rectangle", size, CARBON, -22.5).K
    mirror = np.diag([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # x2 -> -x2
    assert plus[0, 1] > 0.1 * np.sqrt(plus[0, 0] * plus[1, 1])
    assert scaled(mirror @ minus @ mirror - plus, plus).max() < 1e-9


def test_one_mesh_serves_every_material() -> None:
    """The cached mesh and factorisation keep no data of another material."""
    size = {"width": 0.05, "height": 0.02}
    first = solved("rectangle", size, ALUMINIUM)
    other = solved("rectangle", size, CARBON, 30.0)
    again = solved("rectangle", size, ALUMINIUM)
    assert scaled(other.K - first.K, first.K).max() > 0.1
    assert np.array_equal(again.K, first.K)
    assert np.array_equal(again.M, first.M)
