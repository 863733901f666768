"""Ply stresses of a beam package from a real section: beam theory, statics and laminate theory."""

import copy
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.ply_stresses import beam_ply_stress, body_strength
from samples.body_specs import beam_body
from samples.recovery_samples import PLY_CRITERIA, mode_resultants

from plymotion.preprocess.beam.beam_body import beam_model
from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.line import LineSection
from plymotion.preprocess.body import RECOVERY_DEGREE, build_body
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.package import ModalPackage, read_package, validate, write_package
from plymotion.solver.package.common.materials import bond
from plymotion.solver.package.section.section_schema import SectionFile
from plymotion.solver.package.section.stress import resultants

LENGTH = 0.5
STEEL = {
    "kind": "isotropic",
    "E": 210e9,
    "nu": 0.3,
    "rho": 7850.0,
    "strength": {"yield_stress": 355e6},
}
CFRP = {
    "kind": "orthotropic",
    "E1": 142e9,
    "E2": 9.8e9,
    "E3": 9.8e9,
    "G12": 6e9,
    "G13": 6e9,
    "G23": 4.8e9,
    "nu12": 0.3,
    "nu13": 0.3,
    "nu23": 0.34,
    "rho": 1600.0,
    "strength": {"Xt": 1500e6, "Xc": 1200e6, "Yt": 50e6, "Yc": 200e6, "S12": 70e6},
}


def laminate(*angles: float) -> list[dict[str, Any]]:
    return [{"material": "cfrp", "angle_deg": angle} for angle in angles]


def bar(width: float, height: float, plies: list[dict[str, Any]]) -> dict[str, Any]:
    """A rectangle of plies stacked along x3, three rows of elements each."""
    rows = (np.arange(3 * len(plies)) + 1.0) / (3 * len(plies))
    columns = 0.5 - 0.5 * np.cos(np.pi * (np.arange(24) + 1.0) / 24)
    parameters = {"width": width, "height": height, "rows": [*rows], "columns": [*columns]}
    return {
        "name": "bar",
        "convention": "contour",
        "mesh": {"script": "rectangle", "parameters": parameters},
        "materials": {"steel": STEEL, "cfrp": CFRP},
        "regions": {"section": {"plies": plies, "direction": {"vector": [1.0, 0.0]}}},
    }


def box(*angles: float) -> dict[str, Any]:
    """The box of meshes/box.geo in its default size, the same angles on all walls."""
    directions = {"top": [1.0, 0.0], "right": [0.0, -1.0], "bottom": [-1.0, 0.0]}
    directions["left"] = [0.0, 1.0]
    return {
        "name": "box",
        "convention": "contour",
        "mesh": {"script": "box", "parameters": {}},
        "materials": {"cfrp": CFRP},
        "regions": {
            wall: {"plies": laminate(*angles), "direction": {"vector": direction}}
            for wall, direction in directions.items()
        },
    }


STEEL_BAR = bar(0.02, 0.05, [{"material": "steel"}])
BOX = box(30.0, 0.0, 30.0, 0.0, 30.0, 0.0)


def body_spec(section: dict[str, Any], modes: list[dict[str, Any]]) -> dict[str, Any]:
    section = copy.deepcopy(section)
    return beam_body(body="arm", length=LENGTH, elements=40, section=section, modes=modes)


def held_statically(section: dict[str, Any], load_E: np.ndarray) -> tuple[ModalPackage, Any]:
    """A package with one shape, the static response to a load at the tip; its resultants.

    load_E : (6,) force and moment along the section's axes
    """
    spec = body_spec(section, [{"kind": "lowest", "count": 1}])
    package = build_body(spec)
    model = beam_model(read_spec(spec), LineSection(package.sections[0].K, package.sections[0].M))
    line, load = model.line, np.zeros(6 * model.line.n_node)
    load[-6:] = np.kron(np.eye(2), line.A_BE[0]) @ load_E
    K = line.stiffness().toarray()
    shape = np.concatenate([np.zeros(6), np.linalg.solve(K[6:, 6:], load[6:])])[:, None]
    package = dataclasses.replace(
        package,
        shapes_B=shape.reshape(1, line.n_node, 6),
        recovery=mode_resultants(line, shape, np.zeros(1), "consistent", (0,)),
    )
    root = load_E.copy()
    root[4] += -LENGTH * load_E[2]
    root[5] += LENGTH * load_E[1]
    return package, root


def section_of(spec: dict[str, Any]) -> SectionFile:
    """The section itself, at the points that a package keeps, nothing rounded."""
    return analyse(spec, estimate=False, recovery_degree=RECOVERY_DEGREE)


def at_root(package: ModalPackage, q: np.ndarray) -> np.ndarray:
    return beam_ply_stress(package, 0, q)[0]


def test_root_stress_of_a_steel_bar_is_m_z_over_i() -> None:
    """A force along x3 at the tip: s11 = -F L x3 / I for any shear stress."""
    force = np.array([0.0, 0.0, 900.0, 0.0, 0.0, 0.0])
    package, _ = held_statically(STEEL_BAR, force)
    recovery = package.sections[0].recovery
    assert recovery is not None
    expected = -900.0 * LENGTH * recovery.points[:, 1] / (0.02 * 0.05**3 / 12)
    stress = at_root(package, np.ones((1, 1)))
    assert np.abs(stress[:, 0] - expected).max() < 2e-6 * np.abs(expected).max()
    # No other normal stress; the shear stress on the axis is 3/2 F/A less the effect of the width.
    assert np.abs(stress[:, [1, 2]]).max() < 1e-6 * np.abs(expected).max()
    assert np.abs(stress[:, 4]).max() == pytest.approx(1.5 * 900.0 / (0.02 * 0.05), rel=0.05)


def test_eigenmodes_carry_the_root_stress_with_their_number() -> None:
    modes = [{"kind": "bending-xz", "count": 12}]
    package = build_body(body_spec(STEEL_BAR, modes))
    tip = next(i for i in package.interfaces if i.name == "tip")
    q = (tip.phi_B.T @ [0.0, 0.0, 900.0]) / np.diag(package.stiffness)
    recovery = package.sections[0].recovery
    assert recovery is not None
    expected = -900.0 * LENGTH * recovery.points[:, 1] / (0.02 * 0.05**3 / 12)
    errors = []
    for count in (3, 6, 12):
        kept = np.where(np.arange(12) < count, q, 0.0)
        errors.append(np.abs(at_root(package, kept[None])[:, 0] - expected).max())
    errors = errors / np.abs(expected).max()
    assert errors[2] < 0.01
    assert errors[1] < 0.7 * errors[0]
    assert errors[2] < 0.7 * errors[1]


@pytest.mark.parametrize(
    "section", [BOX, bar(0.03, 0.012, laminate(30.0, -15.0, 90.0, 0.0))], ids=["box", "bar"]
)
def test_package_and_section_give_the_same_ply_stress(
    section: dict[str, Any], record: Callable[[str, Any], None]
) -> None:
    """All six loads at once: modes to plies, against statics and the section by itself."""
    load = np.array([2000.0, 60.0, -90.0, 25.0, -12.0, 8.0])
    package, root = held_statically(section, load)
    stress = at_root(package, np.ones((1, 1)))
    alone = section_of(section).recovery
    expected = np.einsum("pij,pjk,k->pi", alone.C_M[alone.ply], alone.strain_M, root)
    assert np.abs(stress - expected).max() < 2e-6 * np.abs(expected).max()
    # The stresses integrate to the given resultants.
    stress_B = np.einsum("pij,pj->pi", bond(alone.A_BM), stress)
    back = resultants(alone, stress_B)
    assert np.abs(back - root).max() < 1e-6 * np.abs(root).max()
    # single points at re-entrant corners carry round-off of 1e-8: their mean square does not
    mean_square = alone.weights @ expected**2 / alone.weights.sum()
    record(f"mean square ply stress at the root, {section['name']}", mean_square)


def test_tension_of_a_wide_strip_is_that_of_laminate_theory() -> None:
    """[0 90]s far from its free edges: N11 = F / width, N22 = N12 = 0 of classical laminates."""
    width, height, force = 0.04, 0.001, 4000.0
    strip = bar(width, height, laminate(0.0, 90.0, 90.0, 0.0))
    package, _ = held_statically(strip, np.array([force, 0, 0, 0, 0, 0.0]))
    recovery = package.sections[0].recovery
    assert recovery is not None
    nu21 = CFRP["nu12"] * CFRP["E2"] / CFRP["E1"]
    Q = np.array([[CFRP["E1"], CFRP["nu12"] * CFRP["E2"]], [CFRP["nu12"] * CFRP["E2"], CFRP["E2"]]])
    Q = Q / (1.0 - CFRP["nu12"] * nu21)
    turned = Q[::-1, ::-1]
    A = 0.5 * height * (Q + turned)
    strain = np.linalg.solve(A, [force / width, 0.0])
    stress = at_root(package, np.ones((1, 1)))
    inside = np.abs(recovery.points[:, 0]) < 0.25 * width
    angle = np.array([ply.angle_deg for ply in recovery.plies])[recovery.ply]
    for ply_angle, expected in ((0.0, Q @ strain), (90.0, (turned @ strain)[::-1])):
        found = stress[inside & (angle == ply_angle)]
        assert len(found) > 50
        assert np.abs(found[:, :2] - expected).max() < 1e-3 * np.abs(expected).max()
        assert np.abs(found[:, 2:]).max() < 1e-3 * np.abs(expected).max()


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package of a box with recovery."""
    path = tmp_path_factory.mktemp("arm") / "arm.vtkhdf"
    write_package(path, build_body(body_spec(BOX, [{"kind": "lowest", "count": 6}])))
    return path


@pytest.mark.one_end
def test_package_with_recovery_is_sound_and_small(arm: Path) -> None:
    assert [f for f in validate(arm) if f.level != "note"] == []
    assert arm.stat().st_size < 300_000


@pytest.mark.one_end
def test_package_with_recovery_is_judged_without_fe_code(arm: Path) -> None:
    read = read_package(arm)
    t = np.array([0.1])
    q = 1e-3 * np.sin(read.frequencies * t[:, None]) / (read.frequencies / read.frequencies[0]) ** 2
    found = body_strength(read, t, q)
    assert found is not None
    assert set(found.worst) == PLY_CRITERIA
    assert np.isfinite(found.governing.ratio)
    assert found.governing.ply.region in ("top", "right", "bottom", "left")
