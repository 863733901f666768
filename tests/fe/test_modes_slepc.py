"""Modes by SLEPc: coinciding pairs, reruns, kinds, accuracy at both ends."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from section_specs import rectangle_spec

from plymotion.preprocess.body import build_body
from plymotion.preprocess.modes import ModeError

ALUMINIUM = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}


def bar(modes: list[dict[str, Any]], width: float = 0.01, **changes: Any) -> dict[str, Any]:
    return {
        "body": "bar",
        "kind": "beam",
        "length": 0.5,
        "elements": 20,
        "section": rectangle_spec(width, 0.01, ALUMINIUM),
        "modes": modes,
        "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}},
        **changes,
    }


def test_square_section_separates_the_planes(record: Callable[[str, Any], None]) -> None:
    package = build_body(bar([{"kind": "lowest", "count": 6}]))
    record("square_bar_frequencies", package.frequencies)
    record("square_bar_shapes", package.shapes_B)
    assert package.mode_labels == tuple(f"bending-{p} {i}" for i in (1, 2, 3) for p in ("xy", "xz"))
    assert np.allclose(package.frequencies[::2], package.frequencies[1::2], rtol=1e-9)
    largest = np.abs(package.shapes_B).max(axis=1)  # (m, 6)
    assert (largest[::2, 2] < 1e-6 * largest[::2, 1]).all()
    assert (largest[1::2, 1] < 1e-6 * largest[1::2, 2]).all()
    tip = package.shapes_B[:, -1]
    assert (tip[::2, 1] > 0).all()
    assert (tip[1::2, 2] > 0).all()


def test_reruns_are_equal() -> None:
    spec = bar([{"kind": "lowest", "count": 8}])
    a, b = build_body(spec), build_body(spec)
    assert np.abs(a.shapes_B - b.shapes_B).max() <= 1e-12 * np.abs(a.shapes_B).max()
    assert np.abs(a.stiffness - b.stiffness).max() <= 1e-12 * np.abs(a.stiffness).max()


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
def test_every_kind_is_found_beyond_the_lowest_modes(mass_form: str) -> None:
    kinds = ("bending-xy", "bending-xz", "torsion", "axial")
    requests = [{"kind": kind, "count": 2} for kind in kinds]
    package = build_body(bar(requests, 0.02, mass_form=mass_form))
    assert sorted(package.mode_labels) == sorted(f"{kind} {i}" for kind in kinds for i in (1, 2))
    hz = dict(zip(package.mode_labels, package.frequencies / (2 * np.pi), strict=True))
    # a bar on one end: c / 4 L, 3 c / 4 L; twenty linear elements are good to (k L)^2/24
    speed = np.sqrt(ALUMINIUM["E"] / ALUMINIUM["rho"])
    assert hz["axial 1"] == pytest.approx(speed / 2.0, rel=1e-3)
    assert hz["axial 2"] == pytest.approx(3 * speed / 2.0, rel=3e-3)
    assert hz["torsion 2"] / hz["torsion 1"] == pytest.approx(3.0, rel=5e-3)
    assert hz["bending-xy 1"] / hz["bending-xz 1"] == pytest.approx(2.0, rel=5e-3)
    assert package.invariants.mass_form == mass_form


def test_all_modes_of_a_small_mesh_and_one_more() -> None:
    small = {"elements": 3}
    assert build_body(bar([{"kind": "lowest", "count": 18}], 0.02, **small)).n_mode == 18
    with pytest.raises(ModeError, match=r"4 of kind 'torsion' asked for.*3 torsion"):
        build_body(bar([{"kind": "torsion", "count": 4}], 0.02, **small))


def test_coarse_mesh_is_reported() -> None:
    fine = build_body(bar([{"kind": "bending-xy", "count": 4}]))
    assert fine.provenance["warnings"] == []
    coarse = build_body(bar([{"kind": "bending-xy", "count": 4}], elements=4))
    (warning,) = coarse.provenance["warnings"]
    assert warning["code"] == "mesh-coarse-for-modes"
    assert "bending-xy 4" in warning["message"]
    assert "bending-xy 1" not in warning["message"]
