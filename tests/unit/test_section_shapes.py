"""The library of section shapes: sizes that do not fit, rows that follow plies, contours."""

from itertools import pairwise
from math import dist
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.common.input_table import validated
from plymotion.solver.inputs.section.description import SHAPE_MESHES
from plymotion.solver.inputs.section.shapes.airfoil import contour
from plymotion.solver.inputs.section.shapes.library import SHAPES, expand, shape, walls
from plymotion.solver.inputs.section.shapes.parts import (
    along,
    arc,
    both_ends,
    cosine,
    faces,
    graded_ends,
    rows,
    united,
)

SIZES: dict[str, dict[str, Any]] = {
    "rectangle": {"width": 0.06, "height": 0.015},
    "strip": {"width": 0.06, "height": 0.002},
    "split-rectangle": {"width": 0.1, "height": 0.1, "interface": 0.02},
    "ellipse": {"radius_2": 0.02, "radius_3": 0.01},
    "tube": {"outer_radius": 0.1, "wall": 0.01},
    "box": {"width": 0.0242, "height": 0.0136, "wall": 0.000762},
    "two-cell": {"width": 0.05, "height": 0.02, "wall": 0.001},
    "i": {"height": 0.2, "top_width": 0.1, "wall": 0.01, "wall_web": 0.006},
    "channel": {"height": 0.0254, "top_width": 0.0127, "bottom_width": 0.0254, "wall": 0.0015},
    "polyline": {"x2": [0.0, 0.05, 0.05, 0.0], "x3": [0.1, 0.1, 0.0, 0.0], "wall": 0.002},
    "airfoil": {"contour": "naca0012", "chord": 0.3, "skin": 0.001, "webs": [0.2, 0.5]},
}


def test_every_shape_is_tried() -> None:
    assert SIZES.keys() == SHAPES.keys()


@pytest.mark.parametrize("name", SIZES)
def test_the_script_has_every_parameter(name: str, repository: Path) -> None:
    """Each key that goes to the script is a parameter of it."""
    result = expand(name, SIZES[name])
    if name == "airfoil":
        text = (repository / "meshes" / "airfoil.py").read_text("utf-8")
        assert all(f'"{key}"' in text or "rows_web_" in key for key in result["parameters"])
        return
    text = (repository / "meshes" / f"{result['script']}.geo").read_text("utf-8")
    defined = {part.split('"')[0] for part in text.split('"Parameters/')[1:]}
    assert result["parameters"].keys() == defined


@pytest.mark.parametrize("name", SIZES)
def test_lines_ascend_to_one(name: str) -> None:
    for key, value in expand(name, SIZES[name])["parameters"].items():
        if key.startswith(("rows", "columns")):
            assert value == sorted(set(value))
            assert value[0] > 0.0
            assert value[-1] == 1.0


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        (
            "box",
            {"wall": None},
            r"^wall: missing, expected the thickness of every wall, or wall_top \[m\]",
        ),
        ("box", {"wall_top": 0.013}, r"^wall_top = 0.013: .*less than the height, 0.0136 \[m\]"),
        ("box", {"wall_left": 0.0235}, r"^wall_left = 0.0235: .*less than the width, 0.0242"),
        ("two-cell", {"web_position": 0.03}, r"^web_position = 0.03: .*from -0.0235 to 0.0235"),
        ("i", {"wall_web": 0.1}, r"^wall_web = 0.1: expected less than top_width, 0.1 \[m\]"),
        ("channel", {"bottom_width": 0.001}, r"^wall_web = 0.0015: .*less than bottom_width"),
        ("rectangle", {"height": 1e-9}, r"^height = 1e-09: expected at least 1e-06 of width.*unit"),
        ("tube", {"wall": 0.1}, r"^wall = 0.1: expected below the outer radius, 0.1 \[m\]"),
        ("tube", {"wall": None}, r"^wall: missing, expected the thickness \[m\]"),
        ("rectangle", {"elements_2": 2.5}, r"^elements_2 = 2.5: expected a whole number from 1"),
        ("split-rectangle", {"interface": 0.05}, r"^interface = 0.05: expected inside the width"),
        ("airfoil", {"webs": [0.5, 0.2]}, r"^webs = \[0.5, 0.2\]: expected up to three.*ascending"),
        ("airfoil", {"webs": [0.1, 0.2, 0.3, 0.4]}, r"^webs = .*expected up to three"),
        ("airfoil", {"web": [0.1, 0.2, 0.3]}, r"^web = .*one for each of 2 webs"),
        ("airfoil", {"skin": None}, r"^skin: missing"),
        ("airfoil", {"contour": "naca0021"}, r'^contour = "naca0021": no such file.*naca0012'),
    ],
)
def test_sizes_that_do_not_fit(name: str, change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        expand(name, {**SIZES[name], **change})


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("box", {"width": None}, r"width = None: "),
        ("box", {"width": -1.0}, r"width = -1.0: value should be greater than 0"),
        ("box", {"height": float("nan")}, r"height = nan: value should be a finite number"),
        ("box", {"wall": "thin"}, r'wall = "thin": value should be a valid number'),
        ("box", {"heigth": 1.0}, r"heigth: unknown key; did you mean 'height'"),
        (
            "tube",
            {"span_deg": 400.0},
            r"span_deg = 400.0: value should be less than or equal to 360",
        ),
        ("rectangle", {"grading": 2.0}, r"grading = 2.0: value should be less than or equal to 1"),
        ("ellipse", {"density": 0}, r"density = 0: value should be greater than 0"),
    ],
)
def test_sizes_out_of_bounds(name: str, change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        validated(SHAPE_MESHES[name], {"shape": name, **SIZES[name], **change}, "box.toml")


def test_unknown_shape_and_region() -> None:
    with pytest.raises(InputError, match=r'shape = "boks".*did you mean \'box\''):
        shape("boks")
    with pytest.raises(InputError, match=r"^regions.topp: .*did you mean 'top'"):
        expand("box", SIZES["box"], {"topp": [1.0]})


def test_walls_of_an_airfoil_follow_its_webs() -> None:
    names = {
        n: [wall.region for wall in walls("airfoil", {"webs": [0.2, 0.4, 0.6][:n]})]
        for n in range(4)
    }
    assert names[0] == ["skin"]
    assert names[1] == ["skin-front", "skin-rear", "web-1"]
    assert names[2] == ["skin-front", "cap-upper", "cap-lower", "skin-rear", "web-1", "web-2"]
    assert names[3] == [*names[2], "web-3"]


def test_layer_directions_turn_clockwise_around_a_box() -> None:
    """y3 = x1 x y2, y2 turned by +90 degrees, points out of every wall."""
    outward = {"top": [0.0, 1.0], "right": [1.0, 0.0], "bottom": [0.0, -1.0], "left": [-1.0, 0.0]}
    for wall in walls("box", {}):
        y2 = wall.direction["vector"]
        assert [-y2[1], y2[0]] == outward[wall.region]


def test_one_row_for_every_ply() -> None:
    plies = [0.2, 0.1, 0.2, 0.2, 0.1, 0.2]
    layers = {region: plies for region in ("top", "right", "bottom", "left")}
    lines = expand("box", SIZES["box"], layers)["parameters"]["rows"]
    assert lines == pytest.approx([0.2, 0.3, 0.5, 0.7, 0.8, 1.0])


def test_walls_that_meet_share_all_their_rows() -> None:
    layers = {"top": [1.0] * 4, "right": [1.0] * 6, "bottom": [1.0] * 4, "left": [1.0] * 6}
    lines = expand("box", SIZES["box"], layers)["parameters"]["rows"]
    assert lines == pytest.approx([1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, 5 / 6, 1])


def test_skin_and_caps_share_rows_at_the_same_depth() -> None:
    values = {**SIZES["airfoil"], "cap": 0.003}
    layers = {"skin-front": [1, 1], "skin-rear": [1, 1], "cap-upper": [1] * 6, "cap-lower": [1] * 6}
    lines = expand("airfoil", values, layers)["parameters"]["faces"]
    assert lines == pytest.approx([0.0005, 0.001, 0.0015, 0.002, 0.0025, 0.003])


def test_more_density_means_more_elements() -> None:
    for name, sizes in SIZES.items():
        plain = expand(name, sizes)["parameters"]
        dense = expand(name, {**sizes, "density": 2.0})["parameters"]
        more = {
            key: (
                sum(dense[key]) > sum(plain[key])
                if isinstance(plain[key], list)
                else dense[key] > plain[key]
            )
            for key in plain
            if key.startswith(("elements", "even", "rows", "columns", "density"))
        }
        assert more, name
        assert all(more.values()), (name, more)


def test_rows_of_few_plies_thin_out_towards_corners() -> None:
    inner = rows([1.0], 5, "inner")
    sizes = [b - a for a, b in pairwise([0.0, *inner])]
    assert len(inner) == 5
    assert sizes == sorted(sizes, reverse=True)
    both = rows([1.0], 6, "both")
    assert [1.0 - x for x in reversed(both[:-1])] == pytest.approx(both[:-1])
    assert rows([0.5, 1.0], 5, "inner")[:2] == pytest.approx([0.25, 0.5])
    assert rows([0.25, 1.0], 3) == pytest.approx([0.25, 0.5, 0.75, 1.0])


def test_a_thick_ply_gets_several_rows() -> None:
    """A sandwich: the core has more than one element."""
    lines = rows(faces([0.05, 0.9, 0.05]), 5, "inner")
    assert lines == pytest.approx([0.05, 0.35, 0.65, 0.95, 1.0])


def test_faces_that_nearly_coincide_become_one() -> None:
    assert united([[0.5, 1.0], [0.5 + 1e-6, 1.0]]) == [0.5, 1.0]
    assert united([[0.5, 1.0], [0.6, 1.0]]) == [0.5, 0.6, 1.0]


@pytest.mark.parametrize(("length", "wall"), [(0.012, 0.00076), (1.0, 0.001), (0.001, 0.001)])
def test_elements_along_a_wall_fill_it(length: float, wall: float) -> None:
    line = along(length, wall)
    n, growth, graded, even = (line[key] for key in ("elements", "growth", "graded", "even"))
    assert 0.0 < graded < length
    first = graded * (growth - 1) / (growth**n - 1)
    last = first * growth ** (n - 1)
    rest = (length - graded) / even
    assert first <= wall / 12 * (1 + 1e-9)
    assert rest <= length / 4 * (1 + 1e-9)
    assert 0.3 * last < rest < 2.0 * 1.7 * last or n == 1 or even == 1


@pytest.mark.parametrize("density", [0.1, 0.25, 0.4, 0.5, 1.0, 3.0])
def test_elements_along_a_wall_rise_to_its_middle_at_any_density(density: float) -> None:
    """In coarse meshes of thin walls, elements that grow by 8 went beyond the middle."""
    for thickness in np.geomspace(1e-6, 1.0, 80):
        line = along(1.0, thickness, density)
        assert line["graded"] <= 0.75 * (1.0 + 1e-12)
        ends = np.array([0.0, *both_ends(1.0, thickness, density)])
        assert np.diff(ends).min() >= 0.9 * min(ends[1], 0.125, 0.0625 / density)


def test_spacings() -> None:
    assert cosine(4, 0.0) == pytest.approx([0.25, 0.5, 0.75, 1.0])
    assert cosine(2, 1.0) == pytest.approx([0.5, 1.0])
    assert graded_ends(3, 0.5) == pytest.approx([4 / 7, 6 / 7, 1.0])


@pytest.mark.parametrize(("span", "step", "first"), [(180, 10, 1), (180, 10, 20), (5, 0.8, 0.1)])
def test_patches_of_an_open_arc(span: float, step: float, first: float) -> None:
    table = arc(span, step, first)
    ends = [0.0, *table["patches"]]
    lengths = [span * (b - a) for a, b in pairwise(ends)]
    assert lengths[0] == pytest.approx(lengths[3])
    assert lengths[1] == pytest.approx(lengths[2])
    assert max(lengths) < 180.0
    assert lengths[1] / table["elements"][1] <= step * (1 + 1e-9)
    n, growth = table["elements"][0], table["growth"][0]
    assert lengths[0] * (growth - 1) / (growth**n - 1) <= first * (1 + 1e-9)
    assert table["growth"][3] == pytest.approx(1 / growth)


NOSE = [(1.0, 0.001), (0.7, 0.03), (0.4, 0.06), (0.2, 0.05), (0.05, 0.03), (0.0, 0.0)]
TAIL = [(0.05, -0.03), (0.2, -0.05), (0.4, -0.06), (0.7, -0.03), (1.0, -0.001)]


@pytest.mark.parametrize(
    "text",
    [
        "AIRFOIL\n" + "\n".join(f"{x} {y}" for x, y in NOSE + TAIL),
        "\n".join(f" {x:.6f}, {y:.6e}" for x, y in reversed(NOSE + TAIL)),
        "AIRFOIL\n 6. 6.\n\n"
        + "\n".join(f"{x} {y}" for x, y in reversed(NOSE))
        + "\n\n"
        + "\n".join(f"{x} {y}" for x, y in [NOSE[-1], *TAIL]),
    ],
    ids=["selig", "reversed", "lednicer"],
)
def test_contour_files(text: str, tmp_path: Path) -> None:
    path = tmp_path / "wing.dat"
    path.write_text(text)
    assert contour(str(path)) == [list(point) for point in NOSE + TAIL]


@pytest.mark.parametrize("text", ["no numbers\n", "1 0\n0.5 0.1\n0 0\n", "0 0\n" * 12])
def test_files_that_are_no_contour(text: str, tmp_path: Path) -> None:
    path = tmp_path / "wing.dat"
    path.write_text(text)
    with pytest.raises(InputError, match=r"^contour: .*wing.dat holds \d+ points, expected"):
        contour(str(path))


@pytest.mark.parametrize("name", ["naca0012", "naca4415"])
def test_shipped_contours_are_naca_sections(name: str) -> None:
    """The last two digits are the largest thickness, across the mean line, in per cent."""
    points = contour(name)
    assert points[0][0] == pytest.approx(1.0, abs=2e-3)
    across = [dist(a, b) for a, b in zip(points, reversed(points), strict=True)]
    assert max(across) == pytest.approx(int(name[-2:]) / 100, rel=2e-3)
