"""Resultants inside segments without vibrations: closed forms, and a beam in one piece."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.segment_samples import MATERIAL, SECTION, cantilever, run_of

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.inputs.case.bodies.specifications import BodySpecs
from plymotion.solver.inputs.case.checks import in_parts
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.run.execution import execute

L, MU, G = 2.0, 3.0, 9.81
K = np.diag([1e7, 1e7, 1e7, 4e4, 9e4, 6e4])
CENTRED = SectionMass(MU, np.zeros(3), np.diag([2e-3, 1e-3, 1e-3])).matrix()
ECCENTRIC = SectionMass(MU, np.array([0.0, 0.01, -0.02]), np.diag([2e-3, 1e-3, 1e-3])).matrix()
PLACES = [0.0, 0.13, 0.5, 0.77, 1.4, 1.99]
COMPONENTS = ("F1", "F2", "F3", "M1", "M2", "M3")


def cuts(method: str = "auto", places: list[float] = PLACES) -> dict[str, Any]:
    return {
        f"{c}-{k}": {"kind": "resultant", "body": "beam", "x": x, "component": c, "method": method}
        for k, x in enumerate(places)
        for c in COMPONENTS
    }


def found(table: dict[str, Any], mass: np.ndarray = CENTRED) -> np.ndarray:
    """Resultants (k, places, 6)."""
    result, summary = execute(run_of(table, (K, mass)), progress=False)
    assert summary["completed"]
    values = np.array([s.values for s in result.signals if s.name[:2] in COMPONENTS])
    return values.reshape(-1, 6, len(result.t)).transpose(2, 0, 1)


@pytest.mark.parametrize("segments", [1, 3])
def test_cantilever_under_gravity(segments: int) -> None:
    """With the load of a mass and a force inside: shear and moment of the part beyond."""
    table = cantilever(
        segments,
        L,
        body={"interfaces": {"root": {"at": "start"}, "in": {"at": 0.6}, "tip": {"at": "end"}}},
        gravity=[0.0, -G, 0.0],
        masses={"m": {"at": "beam.in", "mass": 2.0}},
        forces={
            "pull": {
                "kind": "force",
                "at": "beam.tip",
                "direction": [0.0, 0.0, 1.0],
                "law": {"constant": 5.0},
            }
        },
        signals=cuts("equilibrium" if segments == 1 else "auto"),
    )
    if segments == 1:
        table["bodies"]["beam"]["modes"] = [
            {"kind": "attachment", "at": "tip", "directions": ["y", "z"]}
        ]
    stiff = {"t_end": 1e-3, "output_step": 1e-3, "start": "equilibrium"}
    values = found(table | {"solver": stiff})[0]
    x = np.array(PLACES)
    left = L - x
    beyond = x < 1.2 - 1e-9
    V = -MU * G * left - 2.0 * G * beyond
    M3 = -0.5 * MU * G * left**2 - 2.0 * G * (1.2 - x) * beyond
    expected = np.column_stack([0 * x, V, 5.0 + 0 * x, 0 * x, -5.0 * left, M3])
    # Slopes of 2e-3 turn the axes and shorten the arms.
    np.testing.assert_allclose(values, expected, atol=4e-3 * 60.0)
    np.testing.assert_allclose(values[:, [1, 2, 4, 5]], expected[:, [1, 2, 4, 5]], atol=2e-3)


@pytest.mark.parametrize("segments", [1, 3])
def test_rotating_rod(segments: int) -> None:
    """F1 = 1/2 mu Omega^2 (L^2 - x^2)."""
    Omega = 4.0  # stretches the rod by 1e-5
    table = cantilever(segments, L, signals=cuts("equilibrium" if segments == 1 else "auto"))
    table["joints"] = {
        "hub": {
            "kind": "revolute",
            "between": ["ground.wall", "beam.root"],
            "axis": [0.0, 0.0, 1.0],
            "drive": {"speed": Omega},
        }
    }
    if segments == 1:
        table["bodies"]["beam"]["modes"] = [{"kind": "static-axial"}]
    table["solver"] |= {"start": "quasi-static", "t_end": 0.05, "output_step": 0.01, "rtol": 1e-8}
    values = found(table)
    x = np.array(PLACES)
    expected = 0.5 * MU * Omega**2 * (L**2 - x**2)
    np.testing.assert_allclose(values[:, :, 0], np.tile(expected, (6, 1)), atol=1e-4 * expected[0])
    assert np.abs(values[:, :, 1:]).max() < 1e-6 * expected[0]


def test_a_swinging_beam_in_segments_is_that_in_one_piece() -> None:
    """A pendulum with eccentric sections: one body with 9 modes, and 4 segments without any."""
    joints = {
        "hinge": {
            "kind": "revolute",
            "between": ["ground.wall", "beam.root"],
            "axis": [0.0, 1.0, 0.0],
        }
    }
    solver = {"t_end": 0.6, "output_step": 0.02, "geometric_stiffening": True, "rtol": 1e-7}
    solver["start"] = "quasi-static"
    common = {"gravity": [0.0, 0.0, -G], "joints": joints, "solver": solver}
    one = cantilever(1, L, **common, signals=cuts("equilibrium"))
    many = cantilever(4, L, **common, signals=cuts())
    whole = found(one_with_modes(one), ECCENTRIC)
    parts = found(many, ECCENTRIC)
    scale = np.array([*[np.abs(whole[..., :3]).max()] * 3, *[np.abs(whole[..., 3:]).max()] * 3])
    assert (np.abs(parts - whole) / scale).max() < 5e-4
    # What the modes of the segments alone give: without the distributed inertia between their ends.
    modal = found(cantilever(4, L, **common, signals=cuts("modes")), ECCENTRIC)
    assert (np.abs(modal - whole) / scale).max() > 2e-2


def one_with_modes(table: dict[str, Any]) -> dict[str, Any]:
    table["bodies"]["beam"] |= {
        "elements": 16,
        "reference": {"kind": "chord", "at": ["root", "tip"]},
        "modes": [
            {"kind": "bending-xz", "count": 4},
            {"kind": "bending-xy", "count": 2},
            {"kind": "torsion", "count": 2},
            {"kind": "static-axial"},
        ],
    }
    return table


def test_other_beams_are_refused() -> None:
    table = cantilever(1, L, signals=cuts("equilibrium"))
    table["bodies"]["beam"]["twist_deg"] = [[0.0, 0.0], [1.0, 20.0]]
    whole = {"materials": {"m": MATERIAL}, "sections": {"s": SECTION}, **table}
    *_, told = in_parts(Mechanism.model_validate(whole), BodySpecs(Path()))
    assert any(
        'method = "equilibrium": expected modes; beam is no straight beam' in t for t in told
    )


@pytest.mark.parametrize("arc_deg", [0.0, 60.0])
def test_resultants_by_modes_in_segments_miss_a_sixth_over_n_squared(arc_deg: float) -> None:
    """Weight on a cantilever, straight or curved: the share of the largest moment that is missing.

    The shapes of inertia loads, `static-inertia`, contain it.
    """
    line = {"line": {"arc_deg": arc_deg, "axis": [0.0, 0.0, 1.0]}} if arc_deg else {}
    stiff = {"t_end": 1e-3, "output_step": 1e-3, "start": "equilibrium"}
    theta = np.radians(arc_deg)
    along = 0.5 * L if not arc_deg else L / theta**2 * (1.0 - np.cos(theta))  # arms of the weight
    across = 0.0 if not arc_deg else L / theta * (1.0 - np.sin(theta) / theta)

    def error(segments: int, modes: list[dict[str, Any]]) -> float:
        table = cantilever(
            segments,
            L,
            body={"modes": modes, **line},
            gravity=[0.0, 0.0, -G],
            signals=cuts("modes", [0.0]),
        )
        M1, M2 = found(table | {"solver": stiff})[0, 0, [3, 4]]
        # Their size: the axes of an element are those of its chord.
        return float(np.hypot(M1, M2) / (MU * G * L * np.hypot(along, across)) - 1.0)

    for n in (2, 4):
        assert error(n, []) == pytest.approx(-1.0 / (6.0 * n**2), rel=0.02)
        # What is left is that of the polygon of the elements.
        assert abs(error(n, [{"kind": "static-inertia"}])) < (6e-3 / n**2 if arc_deg else 1e-6)
