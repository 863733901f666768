"""Meshes of airfoils: contours, webs, trailing edges."""

from typing import Any

import numpy as np
import pytest
from samples.section_mesh_samples import SIZES, library, nodes_of

from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.space.layers import nearest_on_curve
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.solver.inputs.section.shapes.library import expand, walls

AIRFOILS: dict[str, dict[str, Any]] = {
    "no web": {"webs": []},
    "one thick web": {"webs": [0.3], "web": 0.004},
    "two webs": {},
    "three webs": {"webs": [0.15, 0.3, 0.6]},
    "thick caps": {"cap": 0.004},
    "thin caps": {"skin": 0.002, "cap": 0.001},
    "thin rear": {"skin": 0.002, "skin_rear": 0.0005},
    "thicker than the nose is round": {"contour": "naca0012", "skin": 0.006, "skin_rear": 0.001},
    "as thick as the nose is round": {"contour": "naca0012", "skin": 0.0047, "skin_rear": 0.001},
    "other origin": {"origin": 0.25},
}


@pytest.mark.one_end
@pytest.mark.parametrize("change", AIRFOILS.values(), ids=AIRFOILS.keys())
def test_airfoil(change: dict[str, Any]) -> None:
    """Whole, without slivers, and every node of the skin on a row at its depth."""
    sizes = {**SIZES["airfoil"], **change}
    spec = expand("airfoil", sizes)
    mesh = section_mesh(spec, "airfoil.mesh")
    assert mesh.warnings == ()
    assert set(mesh.cells.regions) == {wall.region for wall in walls("airfoil", sizes)}
    faces = np.concatenate([[0.0], spec["parameters"]["faces"]])
    rows = np.sort(np.concatenate([faces, 0.5 * (faces[:-1] + faces[1:])]))
    key = {"skin": "skin_front", "skin-front": "skin_front", "skin-rear": "skin_rear"}
    for region in mesh.cells.regions:
        if region.startswith("web"):
            continue
        x = nodes_of(mesh, region).reshape(-1, 2)
        depth = np.linalg.norm(nearest_on_curve(mesh.curves["outer"], x) - x, axis=1)
        thickness = spec["parameters"][key.get(region, "cap")]
        assert depth.max() == pytest.approx(thickness, rel=5e-4)
        off_row = np.abs(depth[:, None] - rows).min(axis=1)
        assert off_row.max() < 5e-4 * thickness


def test_webs_stand_where_they_are_asked_for() -> None:
    mesh = library("airfoil", webs=[0.25, 0.6], web=[0.002, 0.003], origin=0.1)
    for name, place, wall in (("web-1", 0.25, 0.002), ("web-2", 0.6, 0.003)):
        x = nodes_of(mesh, name)[..., 0]
        middle = 0.3 * (place - 0.1)
        assert [x.min(), x.max()] == pytest.approx([middle - wall / 2, middle + wall / 2])


def test_blunt_trailing_edge_is_kept() -> None:
    """A trailing edge thicker than its skins is not cut off."""
    outline = np.array(expand("airfoil", SIZES["airfoil"])["coordinates"])
    outline[:, 1] += np.where(np.arange(len(outline)) < len(outline) / 2, 1, -1) * (
        0.03 * outline[:, 0]
    )
    sharp = library("airfoil")
    blunt = library("airfoil", contour=outline.tolist())
    assert 0.27 < nodes_of(sharp, "skin-rear")[..., 0].max() < 0.295
    assert nodes_of(blunt, "skin-rear")[..., 0].max() == pytest.approx(0.3, abs=1e-4)
    assert np.ptp(blunt.curves["outer"][..., 0]) == pytest.approx(0.3, abs=3e-4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"skin": 0.025}, "skin_rear = 0.025: too thick, no hollow"),
        ({"webs": [0.3, 0.98]}, "webs: the last one lies behind"),
        ({"skin": 0.012, "webs": [0.03, 0.5], "skin_rear": 0.001}, "webs: .* no room"),
        ({"skin": 0.012, "skin_rear": 0.001}, "skin_front = 0.012: too thick for the nose"),
    ],
)
def test_airfoils_that_cannot_be(change: dict[str, Any], message: str) -> None:
    with pytest.raises(SectionError, match=f"airfoil.py: {message}"):
        section_mesh(expand("airfoil", {**SIZES["airfoil"], **change}), "airfoil.mesh")
