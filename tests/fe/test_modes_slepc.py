"""Modes by SLEPc: coinciding pairs, reruns, kinds, accuracy at both ends."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from samples.body_specs import beam_body
from samples.section_specs import rectangle_spec

from plymotion.preprocess.body import build_body
from plymotion.preprocess.modes.reference import ModeError
from plymotion.solver.package import validate, write_package
from plymotion.solver.package.body.invariants import free_body_mass

ALUMINIUM = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}


def bar(modes: list[dict[str, Any]], width: float = 0.01, **changes: Any) -> dict[str, Any]:
    entries = {"body": "bar", "length": 0.5, "elements": 20, "modes": modes, **changes}
    return beam_body(section=rectangle_spec(width, 0.01, ALUMINIUM), **entries)


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
    with pytest.raises(ModeError, match=r"4 of kind 'torsion' requested.*3 torsion"):
        build_body(bar([{"kind": "torsion", "count": 4}], 0.02, **small))


def test_coarse_mesh_is_reported() -> None:
    fine = build_body(bar([{"kind": "bending-xy", "count": 4}]))
    assert fine.provenance["warnings"] == []
    coarse = build_body(bar([{"kind": "bending-xy", "count": 4}], elements=4))
    (warning,) = coarse.provenance["warnings"]
    assert warning["code"] == "mesh-coarse-for-modes"
    assert "bending-xy 4" in warning["message"]
    assert "bending-xy 1" not in warning["message"]
    some = build_body(bar([{"kind": "bending-xy", "count": 4}], elements=4, candidates=True))
    assert some.provenance["warnings"] == []  # of modes that a plan may not take


ATTACHED = [
    {"kind": "attachment", "at": "tip", "directions": ["rx", "rz"]},
    {"kind": "static-axial"},
]
REFERENCES = [
    {"kind": "clamped", "at": "root"},
    {"kind": "chord", "at": ["root", "tip"]},
    {"kind": "mean-axis"},
]
KINDS = [str(reference["kind"]) for reference in REFERENCES]


@pytest.mark.parametrize("reference", REFERENCES, ids=KINDS)
def test_reference_conditions(
    reference: dict[str, Any], record: Callable[[str, Any], None], tmp_path: Path
) -> None:
    """A slender bar clamped, pinned at both ends, free: beam theory; packages that are sound."""
    modes = [{"kind": "bending-xz", "count": 3}, *ATTACHED]
    package = build_body(bar(modes, 0.02, reference=reference))
    kind = str(reference["kind"])
    record(f"{kind}_frequencies", package.frequencies)
    record(f"{kind}_tip", package.interfaces[1].phi_B)
    assert package.reference_condition == kind
    assert package.provenance["warnings"] == []
    write_package(tmp_path / "bar.vtkhdf", package)
    assert [f for f in validate(tmp_path / "bar.vtkhdf") if f.level != "note"] == []
    # (k L)^2 of the first two; E I / m of the plate 0.02 x 0.01
    roots = {
        "clamped": (3.51602, 22.0345),
        "chord": (9.8696, 39.4784),
        "mean-axis": (22.3733, 61.6728),
    }
    speed = np.sqrt(ALUMINIUM["E"] * 0.01**2 / 12 / ALUMINIUM["rho"])
    expected = np.array(roots[kind]) * speed / 0.5**2
    assert package.frequencies[:2] == pytest.approx(expected, rel=5e-3)
    assert package.mode_kinds[:3] == ("fixed_normal",) * 3
    assert set(package.mode_kinds[3:]) == {"attachment"}


def test_free_square_bar_has_pairs_and_no_rigid_motion(record: Callable[[str, Any], None]) -> None:
    package = build_body(
        bar([{"kind": "lowest", "count": 6}], reference={"kind": "mean-axis"}, elements=30)
    )
    record("free_square_bar_shapes", package.shapes_B)
    assert package.mode_labels == tuple(f"bending-{p} {i}" for i in (1, 2, 3) for p in ("xy", "xz"))
    assert np.allclose(package.frequencies[::2], package.frequencies[1::2], rtol=1e-8)
    momentum = free_body_mass(package)[:6, 6:]
    assert np.abs(momentum).max() < 1e-10 * np.sqrt(package.invariants.mass)


@pytest.mark.parametrize("reference", REFERENCES, ids=KINDS)
def test_all_modes_of_any_frame_are_those_of_one_body(reference: dict[str, Any]) -> None:
    """Free frequencies from the mass of frame and modes together, all three frames the same."""
    modes = [{"kind": "lowest", "count": 18}]
    found = []
    for one in (reference, REFERENCES[0]):
        package = build_body(bar(modes, 0.02, elements=3, reference=one))
        M, K = free_body_mass(package), np.zeros((24, 24))
        K[6:, 6:] = package.stiffness
        shift = package.stiffness[0, 0]
        found.append(1.0 / scipy.linalg.eigh(M, K + shift * M, eigvals_only=True)[::-1] - shift)
    assert found[0][6:12] == pytest.approx(found[1][6:12], rel=1e-8)
    assert np.abs(found[0][:6]).max() < 1e-8 * found[0][6]
