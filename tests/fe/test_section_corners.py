"""Re-entrant corners: found in every mesh, and margins at a stated distance from them."""

from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.inputs.section.shapes.library import SHAPES, expand, walls
from plymotion.solver.package.section.stress import reentrant_corners
from plymotion.solver.report.section.section_text import judged_peaks

pytestmark = pytest.mark.one_end

SIZES: dict[str, dict[str, Any]] = {
    "box": {"width": 0.03, "height": 0.02, "wall": 0.002},
    "tube": {"outer_radius": 0.02, "wall": 0.002},
    "rectangle": {"width": 0.03, "height": 0.02},
}
STEEL = {"kind": "isotropic", "E": 2.1e11, "nu": 0.3, "rho": 7850.0}
TWISTED = np.array([0.0, 0.0, 0.0, 100.0, 0.0, 0.0])


def section(name: str, accuracy: float | None = None, **sizes: Any) -> Any:
    given = {**SIZES[name], **sizes}
    regions = {
        wall.region: {"plies": [{"material": "steel", "angle_deg": 0.0}]}
        for wall in walls(name, given)
    }
    material = {**STEEL, "strength": {"yield_stress": 3e8}}
    spec = {
        "name": name,
        "convention": "contour",
        "mesh": expand(name, given),
        "materials": {"steel": material},
        "regions": regions,
    }
    return analyse(spec, estimate=accuracy is not None, accuracy=accuracy)


@pytest.mark.parametrize(("name", "count"), [("box", 4), ("tube", 0), ("rectangle", 0)])
def test_corners(name: str, count: int) -> None:
    assert name in SHAPES
    found = section(name)
    nodes, sizes = reentrant_corners(found.mesh)
    assert len(nodes) == count
    if count:
        inner = np.array([0.013, 0.008])
        assert np.abs(found.mesh.nodes[nodes]) == pytest.approx(np.tile(inner, (4, 1)))
        assert (sizes > 0.0).all()


@pytest.mark.provokes("stress-at-corner")
def test_margins_at_a_distance_do_not_depend_on_the_mesh() -> None:
    """A box under torsion; hanging nodes of the refined mesh are no corners."""
    coarse, fine = section("box"), section("box", accuracy=2e-5)
    assert fine.provenance["dofs"] > 2 * coarse.provenance["dofs"]
    assert len(reentrant_corners(fine.mesh)[0]) == 4
    least: dict[float | None, list[float]] = {}
    for distance in (None, 5e-4):
        for one in (coarse, fine):
            peaks, warnings = judged_peaks(one, TWISTED, distance)
            ratio = min(r.ratio for peak in peaks for r in peak.reserves.values())
            least.setdefault(distance, []).append(ratio)
            expected = ["stress-at-corner"] if distance is None else []
            assert [w["code"] for w in warnings] == expected
    at_corner, away = (values[1] / values[0] for values in least.values())
    assert at_corner < 0.9
    assert away == pytest.approx(1.0, abs=0.03)
