"""The validator: all findings at once, each naming its dataset."""

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.package_samples import cantilever

from plymotion.solver.package import ModalPackage, Remark, from_stations, validate, write_package
from plymotion.solver.package.body.plausibility import (
    centre_inertia,
    free_body_mass,
    plausibility_findings,
)


def found(findings: list[Remark], level: str, dataset: str) -> bool:
    return any(f.level == level and f.dataset.endswith(dataset) for f in findings)


def test_a_sound_package_has_no_findings(tmp_path: Path) -> None:
    write_package(tmp_path / "a.vtkhdf", cantilever())
    assert validate(tmp_path / "a.vtkhdf") == []


def test_every_layout_error_is_reported_not_only_the_first(tmp_path: Path) -> None:
    path = tmp_path / "a.vtkhdf"
    write_package(path, cantilever())
    with h5py.File(path, "r+") as h5:
        group = h5["modal_package"]
        del group["modes/damping"], group["interfaces/base/weights"]
        del group["mesh/nodes_B"].attrs["unit"]
        del h5["VTKHDF/Types"]
    findings = validate(path)
    assert found(findings, "error", "/modal_package/modes/damping")
    assert found(findings, "error", "/modal_package/interfaces/base/weights")
    assert found(findings, "warning", "/modal_package/mesh/nodes_B")
    assert found(findings, "warning", "/VTKHDF/Types")
    assert found(findings, "error", "content_sha256")


def test_a_view_that_shows_another_mesh_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "a.vtkhdf"
    write_package(path, cantilever())
    with h5py.File(path, "r+") as h5:
        points = 2 * h5["VTKHDF/Points"][()]
        del h5["VTKHDF/Points"]
        h5["VTKHDF/Points"] = points
    assert found(validate(path), "error", "/VTKHDF/Points")


def test_a_file_that_is_no_package_is_one_finding(tmp_path: Path) -> None:
    path = tmp_path / "a.vtkhdf"
    path.write_text("no")
    (finding,) = validate(path)
    assert finding.level == "error"
    assert "not an HDF5 file" in finding.message


def scaled(**factors: float) -> ModalPackage:
    package = cantilever()
    fields = {name: getattr(package.invariants, name) * f for name, f in factors.items()}
    return dataclasses.replace(
        package, invariants=dataclasses.replace(package.invariants, **fields)
    )


def with_interface(**change: object) -> ModalPackage:
    package = cantilever()
    base, tip = package.interfaces
    return dataclasses.replace(package, interfaces=(base, dataclasses.replace(tip, **change)))


@pytest.mark.parametrize(
    ("package", "level", "dataset"),
    [
        (scaled(mass=1 + 3e-6), "error", "invariants/mass"),
        (scaled(S0_B=1.1), "warning", "invariants/S0_B"),
        (scaled(T00_B=0.1), "error", "invariants/T00_B"),
        (scaled(T11_B=1.2), "warning", "invariants/T11_B"),
        (scaled(S_B=2.0), "error", "invariants/S_B"),
        (
            dataclasses.replace(cantilever(), frequencies=cantilever().frequencies * 1.01),
            "warning",
            "modes/frequencies",
        ),
        (
            dataclasses.replace(cantilever(), stiffness=-cantilever().stiffness),
            "error",
            "modes/stiffness",
        ),
        (dataclasses.replace(cantilever(), mass=2 * np.eye(4)), "note", "modes/mass"),
        (dataclasses.replace(cantilever(), damping=-np.eye(4)), "error", "modes/damping"),
        (
            dataclasses.replace(cantilever(), shapes_B=cantilever().shapes_B + 0.01),
            "warning",
            "modes/shapes_B",
        ),
        (with_interface(weights=np.array([0.9])), "error", "interfaces/tip/weights"),
        (with_interface(position_B=np.zeros(3)), "warning", "interfaces/tip/position_B"),
        (with_interface(phi_B=np.ones((3, 4))), "error", "interfaces/tip/phi_B"),
        (with_interface(psi_B=np.ones((3, 4))), "error", "interfaces/tip/psi_B"),
    ],
)
def test_implausible_bodies(package: ModalPackage, level: str, dataset: str) -> None:
    assert found(plausibility_findings(package), level, dataset)


def test_inertia_that_breaks_the_triangle_inequality_is_impossible() -> None:
    package = cantilever()
    J0 = package.invariants.J0_B + np.diag([50.0, 0.0, 0.0])
    impossible = dataclasses.replace(
        package, invariants=dataclasses.replace(package.invariants, J0_B=J0)
    )
    assert "impossible inertia" in str(plausibility_findings(impossible))


def test_rigid_motion_among_the_modes_is_noticed() -> None:
    """A mode that is a translation of the whole body duplicates the frame's motion."""
    package = cantilever()
    shapes = package.shapes_B.copy()
    shapes[0] = 0.0
    shapes[0, :, 1] = 1 / np.sqrt(package.node_mass.sum())
    phi, psi = (np.moveaxis(part, 0, 2) for part in (shapes[..., :3], shapes[..., 3:]))
    mass = np.einsum("k,kai,kaj->ij", package.node_mass, phi, phi)
    mass += np.einsum("kab,kai,kbj->ij", package.node_inertia_B, psi, psi)
    invariants = from_stations(
        package.node_mass, package.nodes_B, phi, psi, package.node_inertia_B, "lumped"
    )
    rigid = dataclasses.replace(package, shapes_B=shapes, mass=mass, invariants=invariants)
    assert "a rigid-body motion" in str(plausibility_findings(rigid))


def test_centre_inertia_of_a_rod() -> None:
    """Equal point masses on a line, by summation by hand."""
    x = np.array([1.0, 2.0, 3.0, 4.0])
    nodes = np.column_stack([x, np.zeros(4), np.zeros(4)])
    none = np.zeros((4, 3, 0))
    invariants = from_stations(np.ones(4), nodes, none, none, np.zeros((4, 3, 3)), "lumped")
    package = dataclasses.replace(cantilever(), invariants=invariants)
    np.testing.assert_allclose(centre_inertia(package), np.diag([0.0, 5.0, 5.0]), atol=1e-12)


def test_free_body_mass_gives_the_kinetic_energy_of_its_nodes() -> None:
    """2T = y' M y for any velocity, against the sum over nodes."""
    package = cantilever()
    y = np.random.default_rng(1).normal(size=10)
    v, w, rate = y[:3], y[3:6], y[6:]
    shape_rate = np.einsum("mkd,m->kd", package.shapes_B, rate)
    v_k = v + np.cross(w, package.nodes_B) + shape_rate[:, :3]
    w_k = w + shape_rate[:, 3:]
    twice = np.einsum("k,ka,ka->", package.node_mass, v_k, v_k)
    twice += np.einsum("ka,kab,kb->", w_k, package.node_inertia_B, w_k)
    assert y @ free_body_mass(package) @ y == pytest.approx(twice, rel=1e-12)


def test_numbers_beyond_all_range_are_a_finding_not_a_crash() -> None:
    huge = np.full((3, 3), 1e308)  # finite, but its trace is not
    package = cantilever()
    package = dataclasses.replace(
        package, invariants=dataclasses.replace(package.invariants, T00_B=huge)
    )
    assert "out of range" in str(plausibility_findings(package))
