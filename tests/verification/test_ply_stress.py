"""Stresses of a beam from its modes against beam theory, exact modes and a full search."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from peers.ply_stresses import beam_ply_stress, body_strength
from samples.beam_samples import coupled_stiffness, dense, straight_line
from samples.body_specs import beam_body
from samples.recovery_samples import (
    PLY,
    PLY_STRENGTH,
    STEEL,
    STEEL_STRENGTH,
    mode_resultants,
    plies_of,
    rectangle_recovery,
)

from plymotion.preprocess.beam.beam_body import BeamModel, beam_model, beam_modes, beam_package
from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.element import Q, Z
from plymotion.preprocess.beam.line import BeamLine, LineSection, section_axes
from plymotion.solver.package import ModalPackage, SectionData, validate, write_package
from plymotion.solver.package.common.recovery_schema import SectionRecovery
from plymotion.solver.package.section.stress import strengths
from plymotion.solver.strength import criteria_of
from plymotion.solver.strength.weakest_plies import resultants

LENGTH, WIDTH, HEIGHT = 0.5, 0.02, 0.05
E, NU, RHO = STEEL["E"], STEEL["nu"], STEEL["rho"]
G, AREA = E / (2 * (1 + NU)), WIDTH * HEIGHT
I2, I3 = WIDTH * HEIGHT**3 / 12, HEIGHT * WIDTH**3 / 12
ISOTROPIC = np.diag([E * AREA, 5 / 6 * G * AREA, 5 / 6 * G * AREA, G * 9.9e-8, E * I2, E * I3])
MASS = RHO * np.diag([AREA, AREA, AREA, I2 + I3, I2, I3])
STEEL_BAR = rectangle_recovery(
    WIDTH, HEIGHT, plies_of(("steel", 0.0)), {"steel": {**STEEL, "strength": STEEL_STRENGTH}}, 4
)
LAYUP = plies_of(("cfrp", 30.0), ("cfrp", -30.0), ("cfrp", 90.0), ("cfrp", 0.0))
LAMINATE = rectangle_recovery(
    WIDTH, HEIGHT, LAYUP, {"cfrp": {**PLY, "strength": PLY_STRENGTH}}, columns=5
)
PLY_CRITERIA = criteria_of(strengths(LAMINATE)["cfrp"])


def static(line: BeamLine, held: int, load: np.ndarray) -> np.ndarray:
    """Displacements (6 n, k) under nodal loads, one node held."""
    free = np.setdiff1d(np.arange(len(load)), 6 * held + np.arange(6))
    K = line.stiffness().toarray()
    columns = np.zeros_like(load)
    columns[free] = np.linalg.solve(K[np.ix_(free, free)], load[free])
    return columns


def tip_loads(line: BeamLine) -> np.ndarray:
    """Unit forces and moments along the section axes at the last node, in body axes."""
    load = np.zeros((6 * line.n_node, 6))
    load[-6:] = np.kron(np.eye(2), line.A_BE[0])
    return load


@pytest.mark.parametrize("held", [0, 2])
def test_static_resultants_are_those_of_statics(held: int) -> None:
    """All couplings, uneven elements, turned axes: F(x) = (1 + (x - L) Q) F_tip to round-off."""
    x = LENGTH * np.array([0.0, 0.13, 0.3, 0.55, 1.0])
    line = straight_line(
        x, coupled_stiffness(ISOTROPIC), MASS, section_axes(np.array([0.0, 0.6, 0.8]))
    )
    columns = static(line, held, tip_loads(line))
    found = mode_resultants(line, columns, np.zeros(6), "consistent", (held,))
    places = [*x[: held + 1], *x[held:]] if held else [*x]
    assert np.array_equal(found.station_x, places)
    after = len(places) - (len(x) - held)  # beyond the held node, its far side included
    for station, place in enumerate(places):
        expected = np.eye(6) + (place - LENGTH) * Q if station >= after else np.zeros((6, 6))
        assert np.abs(found.resultants_E[station] - expected).max() < 1e-10


def exact_resultants(K: np.ndarray, value: float, x: np.ndarray, tip: np.ndarray) -> np.ndarray:
    """Resultants (k, 6) of the exact mode at an eigenvalue near `value`, by transfer matrices.

    d' = Z d + K^-1 F, F' = Q F - w^2 m d from the clamp; scaled to the tip displacement `tip`.
    """

    def transfer(w2: float, length: float) -> np.ndarray:
        return scipy.linalg.expm(length * np.block([[Z, np.linalg.inv(K)], [-w2 * MASS, Q]]))

    def tip_force(w2: float) -> np.ndarray:
        return transfer(w2, LENGTH)[6:, 6:]

    scale = np.sqrt(np.diag(K))
    w2 = value
    for _ in range(4):  # Newton's method for the eigenvalue of a matrix that depends on it
        A = tip_force(w2)
        step = 1e-6 * w2
        derivative = (tip_force(w2 + step) - A) / step
        w2 -= min(scipy.linalg.eigvals(A, derivative), key=abs).real
    _, _, V = np.linalg.svd(tip_force(w2) / scale[:, None] * scale[None, :])
    root = scale * V[-1]
    d_tip = transfer(w2, LENGTH)[:6, 6:] @ root
    root *= (d_tip @ tip) / (d_tip @ d_tip)
    return np.array([transfer(w2, place)[6:, 6:] @ root for place in x])


def mode_error(stiffness: np.ndarray, elements: int, mass_form: str, mode: int) -> float:
    """Largest error of the resultants of a cantilever's mode over the largest resultant.

    In units of sqrt(K_ii), which make forces and moments comparable.
    """
    line = straight_line(np.linspace(0, LENGTH, elements + 1), stiffness, MASS, np.eye(3))
    K, M = line.stiffness()[6:, 6:], line.mass_matrix(mass_form)[6:, 6:]
    values, X = dense(K, M, mode + 1)
    columns = np.vstack([np.zeros((6, mode + 1)), X])
    found = mode_resultants(line, columns, values, mass_form, (0,))
    expected = exact_resultants(stiffness, values[mode], found.station_x, columns[-6:, mode])
    unit = np.sqrt(np.diag(stiffness))
    gap = np.abs(found.resultants_E[:, :, mode] - expected) / unit
    return float(gap.max() / np.abs(expected / unit).max())


@pytest.mark.parametrize(
    ("stiffness", "mass_form", "mode", "order", "largest"),
    [
        # slender bending
        (ISOTROPIC, "consistent", 0, 4, 1e-9),
        (ISOTROPIC, "lumped", 0, 2, 1e-3),
        # rotary inertia, twist and extension in it
        (ISOTROPIC, "consistent", 3, 2, 2e-6),
        (coupled_stiffness(ISOTROPIC), "consistent", 0, 2, 1e-7),
        (coupled_stiffness(ISOTROPIC), "consistent", 2, 2, 4e-6),
        (coupled_stiffness(ISOTROPIC), "lumped", 2, 2, 5e-3),
    ],
)
def test_resultants_of_modes_converge(
    stiffness: np.ndarray, mass_form: str, mode: int, order: int, largest: float
) -> None:
    errors = [mode_error(stiffness, elements, mass_form, mode) for elements in (12, 24)]
    assert errors[1] < largest
    assert math.log2(errors[0] / errors[1]) > order - 0.3


def body(
    recovery: SectionRecovery, count: int, elements: int = 40, **changes: Any
) -> tuple[BeamModel, ModalPackage]:
    """A cantilever of isotropic stiffness with its lowest modes of bending in both planes."""
    kinds = ("bending-xy", "bending-xz")
    requests = [{"kind": kind, "count": count} for kind in kinds]
    entries = {"length": LENGTH, "elements": elements, "modes": requests, **changes}
    spec = beam_body(body="arm", section={}, **entries)
    model = beam_model(read_spec(spec), LineSection(ISOTROPIC, MASS))
    modes = beam_modes(model, dense)
    section = SectionData("bar", ISOTROPIC, MASS, "", recovery)
    return model, beam_package(model, modes, [section], {})


def quasi_static(package: ModalPackage, force_B: np.ndarray) -> np.ndarray:
    """Modal coordinates (1, m) under a constant force at the tip, all motion died out."""
    tip = next(i for i in package.interfaces if i.name == "tip")
    return np.linalg.solve(package.stiffness, tip.phi_B.T @ force_B)[None]


def root_stress(package: ModalPackage, q: np.ndarray) -> np.ndarray:
    assert package.recovery is not None
    assert package.recovery.station_x[0] == 0.0
    return beam_ply_stress(package, 0, q)[0, :, 0]


FORCE = np.array([0.0, 300.0, -800.0])  # at the tip, body axes [N]


def beam_theory() -> np.ndarray:
    """s11 = M2 x3 / I2 - M3 x2 / I3 at the clamp: M2 = -L F3, M3 = L F2."""
    x2, x3 = STEEL_BAR.points.T
    return -LENGTH * FORCE[2] * x3 / I2 - LENGTH * FORCE[1] * x2 / I3


def test_stress_at_the_root_under_a_tip_load() -> None:
    """A static shape gives M z / I to round-off; eigenmodes converge to it with their number."""
    expected = beam_theory()
    largest = np.abs(expected).max()
    errors = []
    for count in (4, 8, 16):
        _, package = body(STEEL_BAR, count)
        gap = root_stress(package, quasi_static(package, FORCE)) - expected
        errors.append(np.abs(gap).max() / largest)
    assert errors[0] < 0.03
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.6 * errors[1]

    model, package = body(STEEL_BAR, 1)
    line = model.line
    columns = static(line, 0, tip_loads(line)[:, :3] @ FORCE[:, None])
    attachment = dataclasses.replace(
        package,
        shapes_B=columns.reshape(1, line.n_node, 6),
        recovery=mode_resultants(line, columns, np.zeros(1), "consistent", (0,)),
    )
    gap = root_stress(attachment, np.ones((1, 1))) - expected
    assert np.abs(gap).max() < 1e-9 * largest


@pytest.mark.parametrize("x2_axis", [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -0.6, 0.8]])
def test_section_axes_turn_with_the_section(x2_axis: list[float]) -> None:
    """The same load along the section's axes gives the same resultants."""
    _, package = body(STEEL_BAR, 6, 20, x2_axis=x2_axis)
    assert package.recovery is not None
    F = resultants(package, quasi_static(package, package.recovery.A_BE @ FORCE))[0, :, 0]
    _, straight = body(STEEL_BAR, 6, 20)
    expected = resultants(straight, quasi_static(straight, FORCE))[0, :, 0]
    assert pytest.approx(expected, rel=2e-3, abs=1e-2 * abs(expected).max()) == F


def test_package_of_a_beam_is_sound(tmp_path: Any) -> None:
    middle = {"kind": "clamped", "at": "middle"}
    for changes in ({}, {"reference": middle, "mass_form": "lumped"}):
        interfaces = {"root": {"at": "start"}, "middle": {"at": 0.5}, "tip": {"at": "end"}}
        _, package = body(LAMINATE, 3, 16, interfaces=interfaces, **changes)
        write_package(tmp_path / "a.vtkhdf", package)
        assert [f for f in validate(tmp_path / "a.vtkhdf") if f.level != "note"] == []


def motion(package: ModalPackage, instants: int = 333) -> tuple[np.ndarray, np.ndarray]:
    """Some seconds of free vibration in all modes."""
    t = np.linspace(0.0, 0.4, instants)
    rng = np.random.default_rng(2)
    amplitude = 0.02 * rng.normal(size=package.n_mode) / (package.frequencies / 1e3) ** 1.5
    q = amplitude * np.sin(package.frequencies * t[:, None] + rng.normal(size=package.n_mode))
    return t, q


def test_lowest_ratio_is_that_of_looking_everywhere() -> None:
    """Every station, point and instant by beam_ply_stress, against the search."""
    _, package = body(LAMINATE, 3, 10)
    t, q = motion(package)
    found = body_strength(package, t, q)
    assert found is not None
    assert found.worst.keys() == {c.name for c in PLY_CRITERIA}
    (ply,) = strengths(LAMINATE).values()
    stress_of = [beam_ply_stress(package, s, q) for s in range(len(found.station_x))]
    for criterion in PLY_CRITERIA:
        worst = found.worst[criterion.name]
        everywhere = np.array([criterion.assess(stress, ply).exposure for stress in stress_of])
        along = found.exposure[criterion.name]
        assert along == pytest.approx(everywhere.max(axis=(1, 2)), rel=1e-9)
        station, instant, point = np.unravel_index(np.argmax(everywhere), everywhere.shape)
        assert worst.ratio == pytest.approx(1.0 / everywhere.max(), rel=1e-9)
        assert worst.x == found.station_x[station]
        assert worst.time == t[instant]
        assert np.array_equal(worst.point, LAMINATE.points[point])
        assert worst.ply == LAYUP[LAMINATE.ply[point]]
        assert worst.stress_M == pytest.approx(stress_of[station][instant, point], rel=1e-9)
    assert found.governing.ratio == min(w.ratio for w in found.worst.values())


def test_ply_stress_is_that_of_the_resultants() -> None:
    """Two routes: modes to plies; statics, beam theory and rotation by hand."""
    _, package = body(LAMINATE, 16)
    q = quasi_static(package, FORCE)
    stress = beam_ply_stress(package, 0, q)[0]
    # By hand: s11 in section axes, then s11 cos^2, s11 sin^2, -s11 sin cos in the ply.
    s11 = -LENGTH * FORCE[2] * LAMINATE.points[:, 1] / I2
    s11 = s11 - LENGTH * FORCE[1] * LAMINATE.points[:, 0] / I3
    s12, s13 = FORCE[1] / AREA, FORCE[2] / AREA
    angle = np.radians([p.angle_deg for p in LAYUP])[LAMINATE.ply]
    c, s = np.cos(angle), np.sin(angle)
    expected = np.stack(
        [
            s11 * c**2 + 2 * s12 * s * c,
            s11 * s**2 - 2 * s12 * s * c,
            0 * s11,
            -s13 * s,
            s13 * c,
            -s11 * s * c + s12 * (c**2 - s**2),
        ],
        axis=1,
    )
    # 16 modes carry the moment to 1 % and the shear force to 5 %
    assert np.abs(stress - expected).max() < 0.01 * np.abs(expected).max()


def test_metal_and_plies_are_judged_apart() -> None:
    """Ply criteria ignore steel; of two materials the weaker one governs."""
    materials = {
        "steel": {**STEEL, "strength": {"yield_stress": 1.0}},
        "cfrp": {**PLY, "strength": PLY_STRENGTH},
        "foam": PLY,
    }
    mixed = rectangle_recovery(
        WIDTH, HEIGHT, plies_of(("cfrp", 0.0), ("steel", 0.0), ("foam", 0.0)), materials
    )
    _, package = body(mixed, 2, 8)
    t, q = motion(package)
    found = body_strength(package, t, q)
    assert found is not None
    assert found.governing.reserve.criterion == "von-mises"
    assert found.governing.reserve.mode == "yield"
    assert {w.ply.material for w in found.worst.values()} == {"steel", "cfrp"}
    assert set(found.worst) == {"von-mises", *(c.name for c in PLY_CRITERIA)}


def test_nothing_is_said_without_strengths_or_recovery() -> None:
    _, package = body(STEEL_BAR, 2, 8)
    t, q = motion(package)
    (bar,) = package.sections
    weak = dataclasses.replace(STEEL_BAR, materials={"steel": STEEL})
    for recovery in (weak, None):
        sections = (dataclasses.replace(bar, recovery=recovery),)
        assert body_strength(dataclasses.replace(package, sections=sections), t, q) is None
    bare = dataclasses.replace(package, recovery=None)
    assert body_strength(bare, t, q) is None
    with pytest.raises(ValueError, match="arm: the package has no recovery of resultants"):
        resultants(bare, q)


def test_body_at_rest_never_fails() -> None:
    _, package = body(STEEL_BAR, 2, 8)
    found = body_strength(package, np.zeros(1), np.zeros((1, 4)))
    assert found is not None
    assert found.governing.ratio == math.inf
