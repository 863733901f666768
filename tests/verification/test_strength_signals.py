"""Strength ratios over time: closed forms of a bent bar, and every point at every instant."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.ply_stresses import beam_ply_stress, body_strength, shell_ply_stress
from samples.case_samples import HEAD, SOLVER
from samples.panel_sample import panel
from samples.recovery_samples import (
    PLY,
    PLY_STRENGTH,
    STEEL,
    STEEL_STRENGTH,
    plies_of,
    rectangle_recovery,
)
from samples.segment_samples import cantilever, run_of

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.signals import StrengthSignal
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.mechanism.build import build
from plymotion.solver.mechanism.built_mechanism import BuiltMechanism
from plymotion.solver.package import ModalPackage
from plymotion.solver.package.common.recovery_schema import SectionRecovery
from plymotion.solver.package.section.stress import strengths
from plymotion.solver.run.execution import read_run
from plymotion.solver.signals import HELD, Recording, sensors
from plymotion.solver.strength import criteria_of
from plymotion.solver.strength.strength_summary import summary

WIDTH, HEIGHT = 0.04, 0.012
MATERIALS = {
    "cfrp": {**PLY, "strength": PLY_STRENGTH},
    "steel": {**STEEL, "strength": STEEL_STRENGTH},
}
LAYUP = rectangle_recovery(
    WIDTH,
    HEIGHT,
    plies_of(("cfrp", 0.0), ("cfrp", 45.0), ("steel", 0.0), ("cfrp", -30.0)),
    MATERIALS,
    columns=5,
)


@pytest.fixture(scope="module")
def arm(
    repository: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[BuiltMechanism, ModalPackage]:
    """A free body with a package of modes."""
    folder = tmp_path_factory.mktemp("arm")
    package = repository / "tests/packages/double-pendulum-limits/arm.layup-2-linear.vtkhdf"
    text = f'\n[bodies.arm]\nkind = "package"\npackage = "{package}"\n'
    file = folder / "case.toml"
    file.write_text(HEAD + text + SOLVER.format(t_end=1.0, step=1.0, more=""))
    write_case(load_case(file), folder / "build")
    spec = read_run(folder / "build/runs/base.json")
    return build(spec.mechanism, spec.packages), spec.packages["arm"]


def with_section(package: ModalPackage, recovery: SectionRecovery) -> ModalPackage:
    (section,) = package.sections
    return dataclasses.replace(package, sections=(dataclasses.replace(section, recovery=recovery),))


def bent(package: ModalPackage, recovery: SectionRecovery) -> ModalPackage:
    """A body whose first mode is pure bending about x2 by 1 N m; the others carry nothing."""
    assert package.recovery is not None
    F = np.zeros_like(package.recovery.resultants_E)
    F[:, 4, 0] = 1.0
    return dataclasses.replace(
        with_section(package, recovery),
        recovery=dataclasses.replace(package.recovery, resultants_E=F),
    )


def values(built: BuiltMechanism, package: ModalPackage, q: np.ndarray, **keys: Any) -> np.ndarray:
    """Values of a signal of the body `arm` with this package at modal coordinates q (k, m)."""
    signal = StrengthSignal.model_validate({"kind": "strength_ratio", "body": "arm", **keys})
    built = dataclasses.replace(built, packages={"arm": package})
    y = np.zeros((len(q), built.model.n_pos + built.model.n_vel + 1))
    y[:, 7 : 7 + q.shape[1]] = q
    recording = Recording(built.model, np.arange(float(len(q))), y)
    return sensors(built, {"signal": signal})["signal"].values(recording)


def modal(package: ModalPackage, count: int = 200) -> np.ndarray:
    rng = np.random.default_rng(5)
    t = np.linspace(0.0, 3.0, count)[:, None]
    return np.sin(t * rng.uniform(5.0, 40.0, package.n_mode) + rng.normal(size=package.n_mode))


def test_bar_in_pure_bending(arm: tuple[BuiltMechanism, ModalPackage]) -> None:
    """R = strength / (M z / I): of tension on one side, of compression on the other."""
    built, package = arm
    bar = rectangle_recovery(WIDTH, HEIGHT, plies_of(("cfrp", 0.0)), MATERIALS)
    package = bent(package, bar)
    moment = np.array([0.0, 120.0, -40.0, 260.0])
    q = np.zeros((4, package.n_mode))
    q[:, 0] = moment
    # the integration points at +-z are the outermost
    z = 0.5 * HEIGHT / np.sqrt(3.0)
    stress = np.abs(moment) * z / (bar.weights @ bar.points[:, 1] ** 2)
    weaker = min(PLY_STRENGTH["Xt"], PLY_STRENGTH["Xc"])
    with np.errstate(divide="ignore"):
        expected = weaker / stress
    assert values(built, package, q, criterion="max-stress") == pytest.approx(expected, rel=1e-12)
    exposure = values(built, package, q, kind="exposure", criterion="max-stress", x=0.05)
    assert exposure == pytest.approx(stress / weaker, rel=1e-12)
    # the side in tension for a positive moment is in compression for a negative one
    upper = values(built, package, q, criterion="max-stress", point=[0.0, 0.5 * HEIGHT])
    limit = np.where(moment > 0.0, PLY_STRENGTH["Xt"], PLY_STRENGTH["Xc"])
    with np.errstate(divide="ignore"):
        assert upper == pytest.approx(limit / stress, rel=1e-12)


def everywhere(package: ModalPackage, q: np.ndarray) -> dict[tuple[str, str], np.ndarray]:
    """Exposure (s, t, p) by material and criterion; 0 at points of other materials."""
    found = {}
    (section,) = package.sections
    recovery = section.recovery
    assert recovery is not None
    assert package.recovery is not None
    material = np.array([ply.material for ply in recovery.plies])[recovery.ply]
    for name, strength in strengths(recovery).items():
        for criterion in criteria_of(strength):
            every = np.array(
                [
                    criterion.assess(beam_ply_stress(package, s, q), strength).exposure
                    for s in range(len(package.recovery.station_x))
                ]
            )
            found[name, criterion.name] = np.where(material == name, every, 0.0)
    return found


def test_lowest_of_a_beam_at_every_instant(arm: tuple[BuiltMechanism, ModalPackage]) -> None:
    """All stations, points and criteria by hand; then those of a ply, a criterion, a station."""
    built, package = arm
    package = with_section(package, LAYUP)
    q = modal(package)
    every = everywhere(package, q)
    worst = np.max([e.max(axis=(0, 2)) for e in every.values()], axis=0)
    assert values(built, package, q, kind="exposure") == pytest.approx(worst, rel=1e-12)
    assert values(built, package, q) == pytest.approx(1.0 / worst, rel=1e-12)
    ply = LAYUP.ply == 3
    of_ply = np.max([e[:, :, ply].max(axis=(0, 2)) for e in every.values()], axis=0)
    found = values(built, package, q, kind="exposure", ply=3, region="plate")
    assert found == pytest.approx(of_ply, rel=1e-12)
    tsai = every["cfrp", "tsai-wu"].max(axis=(0, 2))
    found = values(built, package, q, kind="exposure", criterion="tsai-wu")
    assert found == pytest.approx(tsai, rel=1e-12)
    assert package.recovery is not None
    x = float(package.recovery.station_x[4])
    found = values(built, package, q, kind="exposure", x=x)
    here = np.max([e[4].max(axis=1) for e in every.values()], axis=0)
    assert found == pytest.approx(here, rel=1e-9)


@pytest.mark.parametrize(("kind", "worst"), [("exposure", np.max), ("strength_ratio", np.min)])
def test_without_a_place_all_segments_of_a_beam_count(kind, worst) -> None:
    """The most exposed of segments that move each on its own, at every instant."""
    asked = {"kind": kind, "body": "beam"}
    K = np.diag([1e5, 1e5, 1e5, 50.0, 200.0, 30.0])
    spec = run_of(cantilever(3, 1.0, signals={"whole": asked}), (K, 1e-3 * np.eye(6)))
    packages = {name: with_section(package, LAYUP) for name, package in spec.packages.items()}
    built = build(spec.mechanism, packages)
    parts = {
        name: StrengthSignal.model_validate(asked | {"body": name})
        for name in ("beam-1", "beam-2", "beam-3")
    }
    y = np.random.default_rng(3).normal(size=(9, built.model.n_pos + built.model.n_vel + 1))
    for memory in ({}, {HELD: {}}):
        recording = Recording(built.model, np.arange(9.0), y, memory)
        found = sensors(built, spec.mechanism.signals | parts)
        for _ in range(2):  # the governing points are noted for each segment
            of_parts = [found[name].values(recording) for name in parts]
            np.testing.assert_allclose(
                found["whole"].values(recording), worst(of_parts, axis=0), rtol=1e-12
            )


def test_ranking_of_plies_is_that_of_looking_everywhere(
    arm: tuple[BuiltMechanism, ModalPackage],
) -> None:
    """Ratio, criterion, station and time of every ply; taken in blocks, the same."""
    package = with_section(arm[1], LAYUP)
    q = modal(package, 700)
    t = np.linspace(0.0, 1.0, len(q))
    found = body_strength(package, t, q)
    assert found is not None
    every = everywhere(package, q)
    assert package.recovery is not None
    expected = []
    for number, ply in enumerate(LAYUP.plies):
        own = np.flatnonzero(LAYUP.ply == number)
        best = max(
            ((e[:, :, own].max(), name, e[:, :, own]) for (_, name), e in every.items()),
            key=lambda one: one[0],
        )
        station, instant, _ = np.unravel_index(np.argmax(best[2]), best[2].shape)
        x = package.recovery.station_x[station]
        expected.append((1.0 / best[0], ply, best[1], x, t[instant]))
    expected.sort(key=lambda one: one[0])
    for failure, (ratio, ply, criterion, x, when) in zip(found.plies, expected, strict=True):
        assert failure.ratio == pytest.approx(ratio, rel=1e-12)
        assert (failure.ply, failure.reserve.criterion) == (ply, criterion)
        assert (failure.x, failure.time) == (x, when)
    assert [each["ratio"] for each in summary(found)["plies"]] == [f.ratio for f in found.plies]


def test_lowest_of_a_shell_at_every_instant(arm: tuple[BuiltMechanism, ModalPackage]) -> None:
    """Von Mises of one stress alone is its magnitude; of all cells, and of the nearest one."""
    built, flat = arm
    package = panel(m=flat.n_mode)
    assert package.cell_resultants is not None
    q = 0.01 * modal(package, 60)
    count = len(package.cell_resultants.cell)
    stress = np.array([shell_ply_stress(package, row, q)[:, 0, :, 0] for row in range(count)])
    expected = np.abs(stress).max(axis=2) / STEEL_STRENGTH["yield_stress"]  # (cells, instants)
    found = values(built, package, q, kind="exposure")
    assert found == pytest.approx(expected.max(axis=0), rel=1e-12)
    corners = package.nodes_B[package.connectivity.reshape(-1, 3)[7]]
    near = [float(x) for x in corners.mean(axis=0) + 1e-6]
    found = values(built, package, q, kind="exposure", point=near, region="wall", ply=0)
    assert found == pytest.approx(expected[7], rel=1e-12)
    strength = body_strength(package, np.arange(60.0), q)
    assert strength is not None
    assert strength.plies == (strength.governing,)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"region": "plte"}, "no such region; did you mean 'plate'"),
        ({"ply": 9}, r"ply = 9: expected 0 to 3, the plies of arm"),
        ({"point": [0.0, 0.0, 0.0]}, r"expected 2 numbers, x2, x3 of a beam"),
        ({"x": 7.0}, r"x = 7: expected 0 to"),
        ({"ply": 2, "criterion": "hashin"}, r"has strengths for hashin"),
    ],
)
def test_what_cannot_be_measured_is_said_before_the_run(
    arm: tuple[BuiltMechanism, ModalPackage], keys: dict[str, Any], message: str
) -> None:
    built, package = arm
    with pytest.raises(InputError, match=message):
        values(built, with_section(package, LAYUP), modal(package, 3), **keys)
