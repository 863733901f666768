"""What the figures of a report are made of: curves, plane of motion, outlines, energy balance."""

import dataclasses

import numpy as np
import pytest
import solver_chart
from samples.result_samples import swinging_rod

from plymotion.solver.package import read_package
from plymotion.solver.report.case_figures import crossings, outermost_point, plane, segments, spread
from plymotion.solver.report.report_data import Story
from plymotion.solver.results import BodyGeometry, Signal
from plymotion.solver.run.drawing import _outlines

pytest.importorskip("matplotlib")


def story(name: str, t: np.ndarray, values: np.ndarray) -> Story:
    result = dataclasses.replace(
        swinging_rod(k=len(t)), t=t, signals=(Signal("s", "m", "", values),)
    )
    return Story(name, name, {"completed": True}, result)


def test_curves_that_cross_often_are_told_from_calm_ones() -> None:
    t = np.linspace(0, 1, 1001)
    calm = [story("a", t, np.sin(6 * t)), story("b", t, np.sin(6 * t) * 2 + 0.1)]
    busy = [story("a", t, np.sin(60 * t)), story("b", t, np.sin(66 * t))]
    assert crossings(calm, [s.signal("s") for s in calm]) <= 3
    # sin(60t) - sin(66t) = -2 cos(63t) sin(3t): zeros at 63t = pi/2 + n pi, 20 of them in (0, 1)
    assert crossings(busy, [s.signal("s") for s in busy]) == 20
    assert spread([s.signal("s") for s in calm]) == pytest.approx(2.1, abs=0.01)


def test_motion_is_drawn_in_the_plane_of_motion() -> None:
    result = swinging_rod()
    assert plane(result) == (0, 1)
    turned = dataclasses.replace(result, node_positions_G=result.node_positions_G[:, :, [0, 2, 1]])
    assert plane(turned) == (0, 2)


def test_outermost_point_is_the_tip_of_the_rod() -> None:
    result = swinging_rod()
    assert outermost_point(result.node_positions_G[:, :9, :2]) == 8


def test_outermost_point_of_a_folding_arm_is_its_tip_not_its_elbow() -> None:
    """The elbow of a forearm that is drawn in travels farther than the tip."""
    a = np.linspace(0.0, 1.2, 50)
    elbow = np.column_stack([np.cos(a), np.sin(a)])
    tip = elbow + np.column_stack([np.cos(a * 0.4 - 0.9 * a), np.sin(a * 0.4 - 0.9 * a)])
    points = np.stack([np.zeros((50, 2)), elbow, tip], axis=1)
    travelled = np.linalg.norm(np.diff(points, axis=0), axis=2).sum(axis=0)
    assert travelled[1] > travelled[2]
    assert outermost_point(points) == 2


def test_outlines_of_cells() -> None:
    own = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0]])
    body = BodyGeometry(
        "b",
        np.zeros((5, 3)),
        np.array([0, 1, 2, 3, 0, 1, 4, 2]),
        np.array([0, 4, 7, 8]),
        np.array([9, 21, 1]),
    )
    quad, edge, point = segments(body, own)
    np.testing.assert_array_equal(quad, own[[0, 1, 2, 3, 0]])
    np.testing.assert_array_equal(edge, own[[0, 4, 1]])
    np.testing.assert_array_equal(point, own[[2]])


def test_blades_between_analysed_stations_have_an_outline(repository):
    """Three stations of the blade have cells; chords are linear between them."""
    package = read_package(repository / "tests/packages/wind-turbine/blade-1.gust.vtkhdf")
    outlines, _ = _outlines(package)
    middle = package.nodes_B[:, 0] / package.nodes_B[-1, 0]
    middle = 0.5 * (middle[:-1] + middle[1:])
    chords = np.array([np.ptp(outline.points[:, 0]) for outline in outlines])
    scale = chords[0] / np.interp(middle[0], [0.0, 0.5, 1.0], [0.62, 0.45, 0.28])
    expected = scale * np.interp(middle, [0.0, 0.5, 1.0], [0.62, 0.45, 0.28])
    np.testing.assert_allclose(chords, expected, rtol=0.05)
    assert all(
        np.ptp(outline.points[:, 1]) < 0.25 * c for outline, c in zip(outlines, chords, strict=True)
    )
    assert min(len(outline.loops) for outline in outlines) >= 4  # skin and three cells


def test_energy_balance_notices_a_lost_joule() -> None:
    result = swinging_rod()
    leaky = {**result.energies, "kinetic": result.energies["kinetic"].copy()}
    leaky["kinetic"][250:] -= 0.1
    broken = dataclasses.replace(result, energies=leaky)
    scale = max(leaky["kinetic"].max(), np.ptp(leaky["potential"]))
    assert np.abs(broken.relative_balance).max() == pytest.approx(0.1 / scale, rel=1e-6)


def test_charts_of_the_pages_are_drawn_over_the_old_ones(repository, tmp_path) -> None:
    old = tmp_path / "solver-models.png"
    old.write_bytes(b"a picture of the repository, which no run has written")
    solver_chart.main("models", repository / "docs/charts/solver-models.csv", old)
    assert old.read_bytes().startswith(b"\x89PNG")
