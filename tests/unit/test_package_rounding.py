"""Checks near zero: round-off is accepted, larger deviations are reported.

The tests add round-off of the largest size, so that no result depends on the processor.
"""

import dataclasses
from typing import Any

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, MEAN_AXIS, reduced
from samples.package_samples import cantilever

from plymotion.solver.package import ModalPackage, from_stations
from plymotion.solver.package.body.package_file import content_findings
from plymotion.solver.package.body.plausibility import plausibility_findings
from plymotion.solver.package.common.dataset import field_values
from plymotion.solver.package.common.findings import Remark

SIX = [{"kind": "lowest", "count": 6}]
EPS = np.finfo(float).eps
TABLES = ("Z0_B", "Z1_B", "G3", "G4")


def replaced(package: ModalPackage, part: str, **changes: Any) -> ModalPackage:
    """The package with entries of its `part` (an attribute) changed."""
    new = dataclasses.replace(getattr(package, part), **changes)
    return dataclasses.replace(package, **{part: new})


def at_interface(package: ModalPackage, row: int, **changes: Any) -> ModalPackage:
    interfaces = list(package.interfaces)
    interfaces[row] = dataclasses.replace(interfaces[row], **changes)
    return dataclasses.replace(package, interfaces=tuple(interfaces))


def text(findings: list[Remark]) -> str:
    return "\n".join(f"{f.level} {f.dataset}: {f.message}" for f in findings)


def noise(shape: tuple[int, ...], size: float) -> np.ndarray:
    """Antisymmetric in the last two indices, some ulp of the size."""
    raw = np.random.default_rng(3).normal(size=shape)
    return 8.0 * EPS * size * (raw - np.swapaxes(raw, -1, -2))


def largest_second_order_displacement(package: ModalPackage) -> float:
    return max(float(np.abs(i.H_B).max()) for i in package.interfaces)


def with_table(package: ModalPackage, path: str, added: np.ndarray) -> ModalPackage:
    group, _, name = path.rpartition("/")
    own = getattr(package.second_order, group) if group else package.second_order
    own = dataclasses.replace(own, **{name: getattr(own, name) + added})
    if group:
        own = dataclasses.replace(package.second_order, **{group: own})
    return dataclasses.replace(package, second_order=own)


def unit(package: ModalPackage, name: str) -> float:
    """Size of a table's terms: mass times second-order displacement times the other factors."""
    h, mass = largest_second_order_displacement(package), package.invariants.mass
    phi = max(float(np.abs(i.phi_B).max()) for i in package.interfaces)
    return {"Z0_B": mass * h, "Z1_B": mass * h, "G3": mass * h * phi, "G4": mass * h * h}[name]


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("reference", [CLAMPED, MEAN_AXIS], ids=["clamped", "mean-axis"])
def test_second_order_sums_may_cancel(reference: dict[str, Any], name: str) -> None:
    """In a mean-axis frame all of Z0 is round-off: 1 and -1 are as valid as 1 and 1 there."""
    package = reduced(reference, SIX).package
    shape = getattr(package.second_order, name).shape
    noisy = with_table(package, name, noise(shape, unit(package, name)))
    assert text(content_findings(noisy)) == ""
    if reference is MEAN_AXIS and name == "Z0_B":  # the noise is as large as the table
        Z0 = noisy.second_order.Z0_B
        assert np.abs(Z0 - Z0.swapaxes(1, 2)).max() > 0.1 * np.abs(Z0).max()


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("reference", [CLAMPED, MEAN_AXIS], ids=["clamped", "mean-axis"])
def test_true_asymmetry_is_refused(reference: dict[str, Any], name: str) -> None:
    """A millionth of the sum's terms in one entry, with a sum of zero."""
    package = reduced(reference, SIX).package
    added = np.zeros(getattr(package.second_order, name).shape)
    added[..., 1, 2] = 1e-6 * unit(package, name)
    found = text(content_findings(with_table(package, name, added)))
    assert f"error /modal_package/second_order/{name}: expected symmetry" in found
    assert "[1, 2] and [2, 1] differ" in found or "[2, 1] and [1, 2] differ" in found


@pytest.mark.parametrize("name", ["H_B", "H_psi_B"])
def test_second_order_of_an_interface_may_cancel(name: str) -> None:
    """At the clamped root the displacements of second order are zero except for round-off."""
    package = reduced(CLAMPED, SIX).package
    root, tip = package.interfaces[0], package.interfaces[-1]
    assert root.name == "root"
    assert np.abs(getattr(root, name)).max() == 0.0
    size = float(np.abs(getattr(tip, name)).max())
    left = noise(root.H_B.shape, size)
    assert text(content_findings(at_interface(package, 0, **{name: left}))) == ""
    wrong = np.zeros_like(left)
    wrong[0, 1, 2] = 1e-6 * size
    found = text(content_findings(at_interface(package, 0, **{name: wrong})))
    assert f"interfaces/root/{name}: expected symmetry" in found


def test_no_second_order_displacement_at_all() -> None:
    """Stretch has no second-order displacement: all tables are round-off."""
    modes = [{"kind": "axial", "count": 4}]
    package = reduced(CLAMPED, modes, mass=np.diag([1, 1, 1, 0.03, 0.02, 0.01])).package
    size = float(np.abs(package.shapes_B).max()) ** 2
    for path, value in field_values(package.second_order).items():
        if path in ("pieces/mass", "pieces/phi_B"):  # of the first order
            continue
        assert np.abs(value).max() < 1e-12 * size, path
        package = with_table(package, path, noise(value.shape, size))
    exchanged = package.second_order.G4
    assert np.abs(exchanged - exchanged.transpose(2, 3, 0, 1)).max() > 0.0
    assert text(content_findings(package)) == ""


def test_damping_that_is_rounding() -> None:
    package = cantilever()
    critical = 2.0 * np.sqrt(np.diag(package.stiffness))
    C = noise((4, 4), float(critical.min())) - 8.0 * EPS * np.diag(critical)
    quiet = dataclasses.replace(package, damping=C)
    assert text([*content_findings(quiet), *plausibility_findings(quiet)]) == ""
    C = C + 1e-6 * np.diag(critical)
    C[0, 1] += 1e-6 * critical.min()
    assert "damping: expected a symmetric" in text(
        content_findings(dataclasses.replace(package, damping=C))
    )
    driven = dataclasses.replace(package, damping=-1e-6 * np.diag(critical))
    assert "feeds energy into the body (smallest damping ratio -1e-06)" in text(
        plausibility_findings(driven)
    )


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_mode_without_mass(sign: float) -> None:
    """A mode with a mass that is round-off gives an error for either sign."""
    package = cantilever()
    mass = package.mass.copy()
    mass[2] = mass[:, 2] = 0.0
    mass[2, 2] = sign * 1e-17 * package.mass[2, 2]
    found = text(content_findings(dataclasses.replace(package, mass=mass)))
    assert "modes/mass: expected a positive definite matrix" in found


def test_modes_of_any_size() -> None:
    """Modal masses of 1e-24 to 1: shapes of size 1e-12 are as valid as those of size 1."""
    package = cantilever()
    size = np.array([1e-12, 1e-6, 1e-3, 1.0])
    small = dataclasses.replace(
        package,
        shapes_B=package.shapes_B * size[:, None, None],
        mass=package.mass * np.outer(size, size),
        stiffness=package.stiffness * np.outer(size, size),
        second_order=None,
        interfaces=tuple(
            dataclasses.replace(i, phi_B=i.phi_B * size, psi_B=i.psi_B * size, H_B=None)
            for i in package.interfaces
        ),
    )
    assert text(content_findings(small)) == ""
    small.mass[0, 1] = small.mass[1, 0] = 2e-18  # of unit modes: a correlation of 2
    assert "modes/mass: expected a positive definite" in text(content_findings(small))


@pytest.mark.parametrize("seed", range(8))
def test_stiffness_of_rigid_motions_is_rounding(seed: int) -> None:
    """Two rigid motions and two elastic modes: X'KX of rigid motions is round-off of any sign."""
    package = cantilever()
    rng = np.random.default_rng(seed)
    stiffest = float(package.stiffness[3, 3])
    left = EPS * stiffest * rng.normal(size=(4, 4))
    K = package.stiffness.copy()
    K[:2] = K[:, :2] = 0.0
    K += left + left.T
    kinds = ("rigid", "rigid", "fixed_normal", "fixed_normal")
    free = dataclasses.replace(package, mode_kinds=kinds, stiffness=K, recovery=None)
    found = text(plausibility_findings(free))
    assert "modes/stiffness" not in found
    K = K.copy()
    K[0, 0] = -1e-3 * package.stiffness[2, 2]
    pushed = dataclasses.replace(free, stiffness=K)
    assert "error /modal_package/modes/stiffness" in text(plausibility_findings(pushed))


def inertia_of(nodes: np.ndarray) -> ModalPackage:
    """The cantilever with the invariants of equal point masses, its modes without motion."""
    package = cantilever()
    none = np.zeros((len(nodes), 3, 4))
    m = np.full(len(nodes), package.node_mass.sum() / len(nodes))
    inv = from_stations(m, nodes, none, none, np.zeros((len(nodes), 3, 3)), "lumped")
    return dataclasses.replace(package, invariants=inv)


@pytest.mark.parametrize("distance", [0.0, 1.0, 1e3, 1e6])
def test_inertia_of_a_point_and_of_a_line(distance: float) -> None:
    """Far from the origin the inertia about the centre is a small difference of large numbers."""
    away = distance * np.array([0.6, -0.48, 0.64])
    line = np.linspace(0.0, 1.0, 11)[:, None] * np.array([1.0, 2.0, -2.0]) / 3.0
    for nodes in (away[None], away + line):
        found = text(plausibility_findings(inertia_of(nodes)))
        assert "expected values >= 0" not in found
        assert "impossible inertia" not in found
        assert "no inertia about one axis" in found
        assert "indefinite" not in found


def test_inertia_below_zero_is_refused_wherever_the_body_is() -> None:
    line = np.linspace(0.0, 1.0, 11)[:, None] * np.array([1.0, 0.0, 0.0])
    for x in (0.0, 1e3):
        package = inertia_of(line + np.array([0.0, x, 0.0]))
        T00 = package.invariants.T00_B + np.diag([0.0, -1e-3, 0.0])
        found = text(plausibility_findings(replaced(package, "invariants", T00_B=T00)))
        assert "expected values >= 0" in found


@pytest.mark.parametrize("part", ["phi_B", "psi_B"])
def test_motion_of_an_interface_that_is_rounding(part: str) -> None:
    """A solid has no rotations, a twisted bar no displacements: zero may be written as 1e-17."""
    package = cantilever()
    shapes = package.shapes_B.copy()
    shapes[:, :, slice(0, 3) if part == "phi_B" else slice(3, 6)] = 0.0
    still = np.zeros((3, 4))
    changes = [{"phi_B": i.phi_B, "psi_B": i.psi_B, part: still} for i in package.interfaces]
    package = dataclasses.replace(package, shapes_B=shapes)
    for row, change in enumerate(changes):
        package = at_interface(package, row, **change)
    rounded = at_interface(package, 1, **{part: np.full((3, 4), 1e-17)})
    assert f"interfaces/tip/{part}" not in text(plausibility_findings(rounded))
    moved = at_interface(package, 1, **{part: np.full((3, 4), 1e-4)})
    assert f"interfaces/tip/{part}" in text(plausibility_findings(moved))


@pytest.mark.parametrize("seed", range(8))
def test_singular_section(seed: int) -> None:
    """A section without stiffness in one direction: a matrix of rank 5, rounded."""
    package = cantilever()
    A = np.random.default_rng(seed).normal(size=(6, 5))
    scale = np.sqrt(np.diag(package.sections[0].K))
    section = dataclasses.replace(package.sections[0], K=scale[:, None] * (A @ A.T) * scale)
    found = text(plausibility_findings(dataclasses.replace(package, sections=(section,))))
    assert "sections/bar/K: not positive definite" in found
