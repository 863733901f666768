"""A package in other modes equals the package that was built with these modes."""

from typing import Any

import numpy as np
import pytest
from samples.beam_samples import MASS, NAMES, REFERENCES, STIFFNESS, coupled_stiffness, reduced

from plymotion.solver.errors import PackageError
from plymotion.solver.package.body.package_schema import ModalPackage
from plymotion.solver.package.body.selection import changed_basis, rigid, selected

VIBRATIONS = [{"kind": "lowest", "count": 8}]
LOADS = [{"kind": "attachment", "at": "tip"}, {"kind": "static-axial"}, {"kind": "static-inertia"}]
ASKED: list[dict[str, Any]] = [
    {"kind": "lowest", "count": 3},
    {"kind": "attachment", "at": "tip", "directions": ["y", "rz"]},
]
# With coupled stiffness the elements interpolate this load up to their size only.
AXIAL = [*ASKED, {"kind": "static-axial"}]
DIRECTIONS = ["x", "y", "z", "rx", "ry", "rz"]
COUPLED = coupled_stiffness()


def built(reference: dict[str, Any], modes: list[dict[str, Any]], **changes: Any) -> ModalPackage:
    return reduced(reference, modes, **{"elements": 8, "K": COUPLED, **changes}).package


def arrays(package: ModalPackage) -> dict[str, np.ndarray]:
    """All data that depend on the modes, up to their signs: products of each mode with itself."""
    inv, second = package.invariants, package.second_order
    assert second is not None
    assert package.recovery is not None
    found = {
        "shapes": package.shapes_B,
        "S": inv.S_B.T,
        "T01": np.moveaxis(inv.T01_B, -1, 0),
        "T11": np.moveaxis(inv.T11_B, (2, 3), (0, 1)),
        "J_psi": inv.J_psi_B.T,
        "mass": package.mass,
        "stiffness": package.stiffness,
        "damping": package.damping,
        "resultants": np.moveaxis(package.recovery.resultants_E, -1, 0),
        "Z0": np.moveaxis(second.Z0_B, (1, 2), (0, 1)),
        "Z1": np.moveaxis(second.Z1_B, (2, 3), (0, 1)),
        "G3": second.G3,
        "G4": second.G4,
    }
    for place in package.interfaces:
        assert place.H_B is not None
        assert place.H_psi_B is not None
        found[f"{place.name} phi"] = place.phi_B.T
        found[f"{place.name} psi"] = place.psi_B.T
        found[f"{place.name} H"] = np.moveaxis(place.H_B, (1, 2), (0, 1))
        found[f"{place.name} H_psi"] = np.moveaxis(place.H_psi_B, (1, 2), (0, 1))
    return found


@pytest.mark.parametrize(("K", "asked"), [(COUPLED, ASKED), (STIFFNESS, AXIAL)])
@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_selected_modes_are_those_of_a_package_built_with_them(
    reference: dict[str, Any], K: np.ndarray, asked: list[dict[str, Any]]
) -> None:
    loads = LOADS[:2] if reference["kind"] == "mean-axis" else LOADS
    rich = built(reference, [*VIBRATIONS, *loads], K=K, damping_ratio=0.01)
    found = selected(rich, asked)
    expected = built(reference, asked, K=K, damping_ratio=0.01)
    assert found.n_mode == expected.n_mode
    signs = np.sign(np.einsum("mna,mna->m", found.shapes_B, expected.shapes_B))
    found = changed_basis(found, np.diag(signs))
    np.testing.assert_allclose(found.frequencies, expected.frequencies, rtol=1e-8)
    for name, value in arrays(expected).items():
        gap = np.abs(arrays(found)[name] - value).max()
        assert gap <= 1e-12 + 2e-7 * np.abs(value).max(), name


def test_dropping_a_vibration_leaves_no_hole_in_the_static_shapes() -> None:
    rich = built(REFERENCES[0], [*VIBRATIONS, *LOADS])
    asked = [{"kind": "attachment", "at": "tip", "directions": ["y"]}]
    found = selected(rich, asked)
    tip = next(place for place in found.interfaces if place.name == "tip")
    whole = next(place for place in rich.interfaces if place.name == "tip")
    exact = whole.phi_B[1] @ np.linalg.solve(rich.stiffness, whole.phi_B[1])
    assert tip.phi_B[1] @ np.linalg.solve(found.stiffness, tip.phi_B[1]) == pytest.approx(
        exact, rel=1e-10
    )
    last = rich.mode_labels.index("attachment tip y")
    by_index = whole.phi_B[1, last] ** 2 / rich.stiffness[last, last]
    assert by_index < 0.5 * exact


def test_a_rigid_body_keeps_mass_and_inertia() -> None:
    rich = built(REFERENCES[0], VIBRATIONS)
    body = rigid(rich)
    assert body.n_mode == 0
    assert body.second_order is None
    assert body.interfaces[0].phi_B.shape == (3, 0)
    assert body.invariants.mass == rich.invariants.mass == pytest.approx(MASS[0, 0])
    np.testing.assert_array_equal(body.invariants.T00_B, rich.invariants.T00_B)


def test_any_basis_gives_the_same_energies() -> None:
    rich = reduced(REFERENCES[1], VIBRATIONS, K=STIFFNESS).package
    T = np.random.default_rng(3).normal(size=(8, 8))
    turned, q = changed_basis(rich, T), np.linspace(-1.0, 1.0, 8)
    assert q @ turned.stiffness @ q == pytest.approx((T @ q) @ rich.stiffness @ (T @ q), rel=1e-12)
    back = changed_basis(turned, np.linalg.inv(T))
    assert rich.second_order is not None
    assert back.second_order is not None
    for name in ("Z0_B", "Z1_B", "G3", "G4"):
        one, two = getattr(back.second_order, name), getattr(rich.second_order, name)
        np.testing.assert_allclose(one, two, atol=1e-9 * np.abs(two).max())


def test_modes_that_a_package_lacks_are_reported() -> None:
    rich = built(REFERENCES[0], VIBRATIONS)
    with pytest.raises(PackageError, match="beam: 9 vibrations of kind 'lowest' asked for"):
        selected(rich, [{"kind": "lowest", "count": 9}])
    with pytest.raises(PackageError, match='no interface "tpi" in the package'):
        selected(rich, [{"kind": "attachment", "at": "tpi", "directions": ["x"]}])
