"""The error estimate against true errors, and refinement to an accuracy."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from section_cases import section

from plymotion.preprocess.section import analyse
from plymotion.preprocess.section.estimate import error_of_edges, scaled
from plymotion.preprocess.section.mesh import section_mesh
from plymotion.solver.inputs.section.shapes.library import expand

SMALL = 0.05  # errors below this share of the worst one are irrelevant


CURVED = ["07", "14"]


@cache
def converged(name: str) -> Any:
    """K of a finer mesh and a higher degree; curved walls need the mesh, corners the degree."""
    density, degree = (3.0, 3) if name in CURVED else (1.5, 4)
    return analyse(section(name, density, degree=degree), estimate=False).K


def compared(name: str, density: float, degree: int) -> tuple[Any, Any]:
    """Scaled errors and estimates of all entries."""
    found = analyse(section(name, density, degree=degree))
    exact = converged(name)
    return scaled(found.K - exact, exact), scaled(np.asarray(found.error_estimate), exact)


@pytest.mark.one_end
@pytest.mark.parametrize("name", ["02", "08", "11", "12", "15", "21", "22"])
@pytest.mark.parametrize(("density", "degree"), [(0.5, 2), (1.0, 2), (0.5, 3)])
def test_estimate_bounds_the_error(name: str, density: float, degree: int) -> None:
    """The largest estimate is slightly above the largest error; relevant entries are close."""
    error, estimate = compared(name, density, degree)
    assert 1.0 < estimate.max() / error.max() < 2.6
    counts = error > SMALL * error.max()
    ratio = estimate[counts] / error[counts]
    assert ratio.min() > 0.65
    assert ratio.max() < 2.6


@pytest.mark.parametrize("name", CURVED)
@pytest.mark.parametrize(("degree", "least", "most"), [(2, 1.0, 2.6), (3, 0.9, 1.3)])
def test_estimate_bounds_the_largest_error_of_curved_walls(
    name: str, degree: int, least: float, most: float
) -> None:
    """With degree 3 nearly all of the error is the distance of the edges from circles."""
    error, estimate = compared(name, 1.0, degree)
    assert least < estimate.max() / error.max() < most


def test_estimate_of_round_edges_by_closed_forms() -> None:
    """A disc, and a tube whose inner half is 100 times as stiff: edges between plies count too."""
    nu, G = 0.3, 0.5 / 1.3
    disc = {"section": {"plies": [{"material": "soft"}], "direction": {"vector": [1.0, 0.0]}}}
    plies = [{"material": name, "thickness": 0.25} for name in ("soft", "stiff")]
    wall = {"wall": {"plies": plies, "direction": {"circle": [0.0, 0.0]}}}
    sizes = {"outer_radius": 1.0, "wall": 0.5}
    radii = np.array([1.0, 0.75, 0.5])
    E = np.array([1.0, 100.0])
    area, polar = -np.pi * np.diff(radii**2), -0.5 * np.pi * np.diff(radii**4)
    for mesh, regions, exact in (
        (expand("ellipse", {"radius_2": 1.0}), disc, [np.pi, 0.5 * np.pi * G, 0.25 * np.pi]),
        (
            expand("tube", sizes, {"wall": [0.25, 0.25]}),
            wall,
            [E @ area, G * E @ polar, E @ polar / 2],
        ),
    ):
        found = analyse(
            {
                "mesh": {**mesh, "degree": 3},
                "materials": {
                    name: {"kind": "isotropic", "E": e, "nu": nu, "rho": 1.0}
                    for name, e in (("soft", 1.0), ("stiff", 100.0))
                    if name == "soft" or regions is wall
                },
                "regions": regions,
            }
        )
        error = np.abs(np.diag(found.K)[[0, 3, 4]] / exact - 1.0).max()
        estimate = np.diag(scaled(np.asarray(found.error_estimate), found.K)).max()
        assert 1e-6 < error < estimate < 1.3 * error


@pytest.mark.one_end
def test_straight_edges_have_no_error_of_arcs() -> None:
    """Also with one row of cells, whose middles lie on one line."""
    mesh = section_mesh(expand("rectangle", {"width": 1.0, "height": 1e-5, "elements_3": 1}), "x")
    assert error_of_edges(mesh.cells, np.ones(mesh.cells.n_cell)) < 1e-15


def test_refinement_meets_the_accuracy_and_says_what_it_cost() -> None:
    loose = analyse(section("21", 0.5))
    found = analyse(section("21", 0.5), accuracy=1e-4)
    exact = converged("21")
    assert scaled(np.asarray(found.error_estimate), exact).max() < 1e-4
    assert scaled(found.K - exact, exact).max() < 1e-4
    steps = found.provenance["refinements"]
    assert [step["refine"] for step in steps] == list(range(len(steps)))
    assert steps[0]["dofs"] == loose.provenance["dofs"] < steps[-1]["dofs"]
    assert [step["error"] > 1e-4 for step in steps] == [True] * (len(steps) - 1) + [False]
    assert found.warnings == ()


@pytest.mark.provokes("accuracy-not-met")
def test_an_accuracy_out_of_reach_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    from plymotion.preprocess.section import analysis

    monkeypatch.setattr(analysis, "MOST_DOFS", 5000)
    found = analyse(section("02"), accuracy=1e-9)
    assert [warning["code"] for warning in found.warnings] == ["accuracy-not-met"]
    assert found.provenance["refinements"][-1]["error"] > 1e-9
