"""What a held end takes from the compliance of a beam, against solids with two rigid end faces."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

pytest.importorskip("plymotion.preprocess.fenicsx")

import ufl
from peers.solid_prism import held_compliance
from samples.section_specs import library_spec, rectangle_spec
from samples.shell_specs import CFRP, METAL

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.package.common.materials import material_from_dict
from plymotion.solver.run.error_bars import OTHER_END

Record = Callable[[str, Any], None]
FOAM = {"kind": "isotropic", "E": 70e6, "nu": 0.3, "rho": 60.0}
NAMES = "F1", "F2", "F3", "M1", "M2", "M3"


def of_beam(section: Any, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Compliance (6, 6) of the tip of a beam, and what two held ends take from it."""
    S, flexibility = section.end_compliance, np.linalg.inv(section.K)
    points, weights = np.polynomial.legendre.leggauss(3)

    def carried(rest: float) -> np.ndarray:
        """Resultants at a distance from the tip, of those at the tip."""
        T = np.eye(6)
        T[4, 2], T[5, 1] = -rest, rest
        return T

    places = zip(0.5 * length * (1.0 + points), 0.5 * length * weights, strict=True)
    whole = sum(w * carried(s).T @ flexibility @ carried(s) for s, w in places)
    root = carried(length)
    return np.asarray(whole), root.T @ S @ root + np.outer(OTHER_END, OTHER_END) * S


def sandwich(face: float, core: float) -> dict[str, Any]:
    """A sandwich 40 mm wide: faces of metal, core of foam [m]."""
    plies = [
        {"material": name, "angle_deg": 0.0, "thickness": t}
        for name, t in (("metal", face), ("foam", core), ("metal", face))
    ]
    height = 2.0 * face + core
    found = rectangle_spec(0.04, height, METAL)
    layers = {"section": [face, core, face]}
    found["mesh"] = expand("rectangle", {"width": 0.04, "height": height}, layers)
    found["materials"] = {"metal": METAL, "foam": FOAM}
    found["regions"]["section"]["plies"] = plies
    return found


def constant(material: dict[str, Any]) -> Callable[[Any], Any]:
    C = material_from_dict(material, "m").stiffness_M
    return lambda x: ufl.as_matrix(C.tolist())


def layered(x: Any) -> Any:
    metal, foam = (
        ufl.as_matrix(material_from_dict(m, "m").stiffness_M.tolist()) for m in (METAL, FOAM)
    )
    inner = ufl.conditional(ufl.lt(abs(x[2]), 0.008), 1.0, 0.0)
    return inner * foam + (1.0 - inner) * metal


of_metal = constant(METAL)
compliance = cache(held_compliance)

BARS: dict[str, Any] = {
    "square, twice as long as wide": (
        (0.08, 0.04, 0.04),
        (16, 4, 4),
        of_metal,
        rectangle_spec(0.04, 0.04, METAL),
    ),
    "square, of carbon": (
        (0.16, 0.04, 0.04),
        (20, 4, 4),
        constant(CFRP),
        rectangle_spec(0.04, 0.04, CFRP),
    ),
    "strip": ((0.12, 0.04, 0.004), (24, 12, 2), of_metal, rectangle_spec(0.04, 0.004, METAL)),
    "sandwich": ((0.1, 0.04, 0.02), (24, 4, 10), layered, sandwich(0.002, 0.016)),
}


@cache
def indicated_by(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Compliance (6, 6) of the tip of a bar as a beam, and the share (6,) its ends take from it."""
    size, _, _, spec = BARS[name]
    whole, lost = of_beam(analyse(spec, estimate=False), size[0])
    return whole, np.diag(lost) / np.diag(whole)


@pytest.mark.parametrize("name", BARS)
def test_the_indicated_shares_are_those_of_the_other_end(name: str, record: Record) -> None:
    """Compared with solids on one end, below; equal on both."""
    _, indicated = indicated_by(name)
    assert np.all(np.isfinite(indicated))
    record(f"end-effects/{name}", indicated)


@pytest.mark.one_end
@pytest.mark.parametrize("name", BARS)
def test_held_ends_take_the_compliance_that_a_solid_lacks(name: str) -> None:
    """Each load on the tip: indicated within a factor of 3 of the difference of beam and solid."""
    size, count, stiffness, _ = BARS[name]
    whole, indicated = indicated_by(name)
    solid = compliance(size, count, stiffness)
    true = np.diag(whole - solid) / np.diag(whole)
    seen = np.abs(true) > 2e-3
    assert seen.sum() >= 3
    ratio = indicated[seen] / true[seen]
    assert np.all((ratio > 1.0 / 3.0) & (ratio < 3.0)), dict(zip(NAMES, ratio, strict=False))


@pytest.mark.one_end
def test_the_indicated_share_grows_as_the_bar_gets_shorter() -> None:
    """A square bar of 4, 2 and 1 widths under a force across it: so does the true one."""
    section, shares = analyse(rectangle_spec(0.04, 0.04, METAL), estimate=False), []
    for length in (0.16, 0.08, 0.04):
        whole, lost = of_beam(section, length)
        solid = compliance((length, 0.04, 0.04), (min(round(length / 0.005), 16), 4, 4), of_metal)
        shares.append((lost[2, 2] / whole[2, 2], 1.0 - solid[2, 2] / whole[2, 2]))
    indicated, true = np.array(shares).T
    assert np.all(np.diff(indicated) > 0.0)
    assert np.all(np.diff(true) > 0.0)
    assert np.all((indicated / true > 1.0 / 3.0) & (indicated / true < 3.0))


@pytest.mark.one_end
def test_an_i_section_in_torsion_loses_vlasovs_length() -> None:
    """S / compliance = sqrt(E I_w / (G J)), with I_w = I_3 h^2 / 4 of the middle lines."""
    b, h, t = 0.1, 0.196, 0.004
    sizes = {"height": h + t, "top_width": b, "bottom_width": b, "wall": t}
    section = analyse(library_spec("i", sizes, METAL), estimate=False)
    I_w, J = 2.0 * t * b**3 / 12.0 * h**2 / 4.0, (2.0 * b + h) * t**3 / 3.0
    vlasov = np.sqrt(2.0 * (1.0 + METAL["nu"]) * I_w / J)
    assert section.end_compliance is not None
    found = section.end_compliance[3, 3] * section.K[3, 3]
    assert found == pytest.approx(vlasov, rel=0.03)


def test_ends_of_a_round_tube_in_torsion_take_nothing() -> None:
    """Its section does not warp."""
    section = analyse(
        library_spec("tube", {"outer_radius": 0.05, "wall": 0.002}, METAL), estimate=False
    )
    assert section.end_compliance is not None
    length = np.diag(section.end_compliance) * np.diag(section.K)
    assert abs(length[3]) < 1e-9
    assert length[0] > 1e-4  # Poisson's contraction is held
