"""Plies and their directions: conventions, curves, and errors in a description."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.space.layers import along_walls, nearest_on_curve
from plymotion.preprocess.section.space.section_cells import CellMesh
from plymotion.preprocess.section.space.section_mesh import SectionMesh
from plymotion.preprocess.section.timoshenko import scaled

CARBON = {
    "kind": "orthotropic",
    **{"E1": 141.963e9, "E2": 9.79056e9, "E3": 9.79056e9},
    **{"G12": 5.99844e9, "G13": 5.99844e9, "G23": 4.79875e9},
    **{"nu12": 0.42, "nu13": 0.42, "nu23": 0.42, "rho": 1.0},
}
DIRECTIONS = {"top": [1, 0], "right": [0, -1], "bottom": [-1, 0], "left": [0, 1]}
LAYUP_3 = {
    "top": [15.0] * 6,
    "bottom": [-15.0] * 6,
    "left": [-15.0, 15.0] * 3,
    "right": [15.0, -15.0] * 3,
}
THICKNESS = 0.127e-3


def box(angles: dict[str, list[float]], convention: str = "contour") -> dict[str, Any]:
    walls = {f"wall_{wall}": 6 * THICKNESS for wall in DIRECTIONS}
    return {
        "name": "box",
        "convention": convention,
        "mesh": {"script": "box", "parameters": {"width": 0.0242062, "height": 0.0136398, **walls}},
        "materials": {"carbon": CARBON},
        "regions": {
            wall: {
                "plies": [
                    {"material": "carbon", "angle_deg": a, "thickness": THICKNESS}
                    for a in angles[wall]
                ],
                "direction": {"vector": vector},
            }
            for wall, vector in DIRECTIONS.items()
        },
    }


def tube(plies: list[dict[str, Any]], direction: Any, rows: list[float]) -> dict[str, Any]:
    parameters = {"outer_radius": 0.05, "wall": 0.004, "rows": rows}
    return {
        "name": "tube",
        "convention": "contour",
        "mesh": {"script": "tube", "parameters": parameters},
        "materials": {"carbon": CARBON},
        "regions": {"wall": {"plies": plies, "direction": direction}},
    }


def stiffness(spec: dict[str, Any]) -> Any:
    return analyse(spec, estimate=False).K


@pytest.mark.one_end
def test_one_printed_layup_is_two_beams() -> None:
    """Lay-up 3 bends and twists read along the contour, extends and twists read in fixed axes."""
    contour, cartesian = stiffness(box(LAYUP_3)), stiffness(box(LAYUP_3, "cartesian"))
    # theory: |S45| = 51 N m2 along the contour, |S14| = 7.9e3 N m in fixed axes; their signs turn
    # with the normal, which is the outward one here
    assert contour[3, 4] == pytest.approx(-51.7, abs=0.1)
    assert abs(contour[0, 3]) < 1e-6 * np.sqrt(contour[0, 0] * contour[3, 3])
    assert abs(cartesian[0, 3]) == pytest.approx(7.9e3, rel=0.01)
    assert abs(cartesian[3, 4]) < 0.05 * abs(contour[3, 4])


@pytest.mark.one_end
def test_cartesian_turns_the_angles_of_the_walls_that_run_backwards() -> None:
    """Bottom runs along -x2, right along -x3: there the same angle has the other sign."""
    angles = {"top": [20.0] * 6, "bottom": [30.0] * 6, "left": [40.0] * 6, "right": [50.0] * 6}
    turned = {**angles, "bottom": [-30.0] * 6, "right": [-50.0] * 6}
    K = stiffness(box(angles, "cartesian"))
    assert scaled(stiffness(box(turned)) - K, K).max() < 1e-12


@pytest.mark.one_end
def test_outermost_ply_comes_first() -> None:
    """The fibres on the outside stiffen bending more than those on the inside."""
    first = dict.fromkeys(DIRECTIONS, [0.0] * 3 + [90.0] * 3)
    last = dict.fromkeys(DIRECTIONS, [90.0] * 3 + [0.0] * 3)
    outside, inside = analyse(box(first), estimate=False), analyse(box(last), estimate=False)
    assert outside.K[4, 4] > 1.05 * inside.K[4, 4]
    ply, points = outside.recovery.ply, outside.recovery.points
    top = np.array([p.region == "top" for p in outside.recovery.plies])[ply]
    index = np.array([p.index for p in outside.recovery.plies])[ply]
    for i in range(6):
        depth = 0.0136398 / 2 - points[top & (index == i), 1]
        assert depth.min() > i * THICKNESS - 1e-12
        assert depth.max() < (i + 1) * THICKNESS + 1e-12


RING = """
// a user's own script: four quarters of a ring in four rows, every face of a row an arc
Point(100) = {0, 0, 0};
For j In {0:4}
  For i In {0:3}
    Point(10 * j + i + 1) = {(0.05 - 0.001 * j) * Cos(i * Pi / 2),
                             (0.05 - 0.001 * j) * Sin(i * Pi / 2), 0};
  EndFor
  For i In {0:3}
    Circle(10 * j + i + 1) = {10 * j + i + 1, 100, 10 * j + (i + 1) % 4 + 1};
  EndFor
EndFor
Transfinite Curve {1:44} = 13;
For j In {0:3}
  For i In {0:3}
    Line(100 + 10 * j + i + 1) = {10 * j + i + 1, 10 * (j + 1) + i + 1};
    Transfinite Curve {100 + 10 * j + i + 1} = 2;
  EndFor
  For i In {0:3}
    Curve Loop(10 * j + i + 1) = {10 * j + i + 1, 100 + 10 * j + (i + 1) % 4 + 1,
                                  -(10 * (j + 1) + i + 1), -(100 + 10 * j + i + 1)};
    Plane Surface(10 * j + i + 1) = {10 * j + i + 1};
    Transfinite Surface {10 * j + i + 1};
    Recombine Surface {10 * j + i + 1};
  EndFor
EndFor
Mesh.ElementOrder = 2;
Physical Surface("wall") = {1:4, 11:14, 21:24, 31:34};
Physical Curve("outer") = {1:4};
"""


@pytest.mark.one_end
def test_circle_and_curve_give_the_same_tube(tmp_path: Path) -> None:
    (tmp_path / "ring.geo").write_text(RING)
    plies = [
        {"material": "carbon", "angle_deg": a, "thickness": t}
        for a, t in ((45.0, 0.001), (0.0, 0.003))
    ]
    ring = tube(plies, {"circle": [0.0, 0.0]}, [])
    ring["mesh"] = {"file": str(tmp_path / "ring.geo")}
    K = stiffness(ring)
    ring["regions"]["wall"]["direction"] = {"curve": "outer"}
    assert scaled(stiffness(ring) - K, K).max() < 1e-6
    # a rotation of the tube by 90 deg changes nothing: directions follow the wall
    assert K[1, 1] == pytest.approx(K[2, 2], rel=1e-9)
    assert K[1, 4] == pytest.approx(K[2, 5], rel=1e-9)
    # the library's tube has another mesh of the same section
    library = tube(plies, {"circle": [0.0, 0.0]}, [0.25, 0.5, 0.75, 1.0])
    assert scaled(stiffness(library) - K, K).max() < 1e-4


@pytest.mark.one_end
def test_edges_between_plies_follow_the_wall_where_gmsh_leaves_them_straight(
    tmp_path: Path,
) -> None:
    """The same rows in one surface. They were straight, and K wrong by 1e-2, ten times as much as
    was estimated."""
    one = RING.replace("j In {0:4}", "j In {0:4:4}").replace("j In {0:3}", "j In {0:0}")
    one = one.replace("{1:44}", "{1:4, 41:44}").replace("(j + 1)", "(j + 4)")
    one = one.replace("+ 1} = 2;", "+ 1} = 5;").replace("{1:4, 11:14, 21:24, 31:34}", "{1:4}")
    plies = [{"material": "carbon", "angle_deg": a} for a in (90.0, 45.0, 0.0, 30.0)]
    K = []
    for text, direction in (
        (RING, {"circle": [0.0, 0.0]}),
        (one, {"circle": [0.0, 0.0]}),
        (one, {"curve": "outer"}),
    ):
        (tmp_path / "ring.geo").write_text(text)
        ring = tube(plies, direction, [])
        ring["mesh"] = {"file": str(tmp_path / "ring.geo")}
        K.append(stiffness(ring))
    assert scaled(K[1] - K[0], K[0]).max() < 1e-6
    assert scaled(K[2] - K[0], K[0]).max() < 1e-6


def test_edges_between_two_sides_stay_straight() -> None:
    """From the depths 0 to 0.4 of a block between two outer faces; at 0.3, its middle has 0.3."""
    x, y = np.meshgrid([0.0, 0.5, 1.0, 1.5, 2.0], [0.0, 0.3, 0.6, 0.8, 1.0])
    row = np.arange(25).reshape(5, 5)
    blocks = [row[j : j + 3, i : i + 3] for i, j in ((0, 0), (2, 0), (0, 2), (2, 2))]
    order = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1)]
    cells = CellMesh(
        np.column_stack([x.ravel(), y.ravel()]),
        np.array([[block[at] for at in order] for block in blocks]),
        np.ones(4, dtype=np.int64),
        np.zeros(4, dtype=np.int64),
        ("block",),
    )
    faces = np.array([[[0.0, 0.0], [2.0, 0.0]], [[0.0, 1.0], [2.0, 1.0]]])
    mesh = SectionMesh(cells, {"outer": faces})
    regions = {"block": {"plies": [{}, {}], "direction": {"curve": "outer"}}}
    assert along_walls(mesh, regions, "block") is mesh


def test_equal_shares_without_thickness() -> None:
    rows = [0.5, 1.0]
    named = [{"material": "carbon", "angle_deg": a, "thickness": 0.002} for a in (30.0, 0.0)]
    shares = [{"material": "carbon", "angle_deg": a} for a in (30.0, 0.0)]
    circle = {"circle": [0.0, 0.0]}
    K = stiffness(tube(named, circle, rows))
    assert np.array_equal(stiffness(tube(shares, circle, rows)), K)


@pytest.mark.provokes("plies-not-resolved")
def test_plies_that_cross_cells_are_told() -> None:
    plies = [{"material": "carbon", "angle_deg": a} for a in (30.0, 0.0, 30.0)]
    section = analyse(tube(plies, {"circle": [0.0, 0.0]}, [0.5, 1.0]), estimate=False)
    assert [warning["code"] for warning in section.warnings] == ["plies-not-resolved"]


def test_foot_on_a_curve() -> None:
    """Feet on a circle of quadratic elements: where the ray from its centre meets it."""
    angle = np.linspace(0.0, 2.0 * np.pi, 33)
    half = 0.5 * (angle[1:] + angle[:-1])
    circle = [np.column_stack([np.cos(a), np.sin(a)]) for a in (angle[:-1], angle[1:], half)]
    rng = np.random.default_rng(0)
    ray = rng.uniform(0.0, 2.0 * np.pi, 200)
    radius = rng.uniform(0.6, 0.98, 200)
    unit = np.column_stack([np.cos(ray), np.sin(ray)])
    feet = nearest_on_curve(np.stack(circle, axis=1), radius[:, None] * unit)
    # the quadratic elements leave the circle by 3e-6 and their tangents by 1e-4
    assert np.abs(np.linalg.norm(feet, axis=1) - 1.0).max() < 4e-6
    assert np.abs(feet - unit).max() < 5e-4
    # a straight corner: the foot of a point beyond it is the corner itself
    corner = np.array([[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 1.0]]])
    feet = nearest_on_curve(corner, np.array([[0.5, -1.0], [2.0, -1.0], [3.0, 0.25]]))
    assert feet == pytest.approx(np.array([[0.5, 0.0], [1.0, 0.0], [1.0, 0.25]]))


def changed(**change: Any) -> dict[str, Any]:
    spec = box(LAYUP_3)
    for key, value in change.items():
        table: Any = spec
        *path, last = key.split("__")
        for step in path:
            table = table[step]
        if value is None:
            del table[last]
        else:
            table[last] = value
    return spec


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"convention": "contur"}, r"f\.convention = 'contur'.*did you mean 'contour'"),
        ({"regions__top": None}, r"f\.regions\.top: missing"),
        ({"regions__topp": {"plies": []}}, r"f\.regions\.topp: .*no such region.*'top'"),
        (
            {"regions__top__plies": [{"material": "karbon", "angle_deg": 0.0}]},
            r"f\.regions\.top\.plies\[0\]\.material = 'karbon'.*did you mean 'carbon'",
        ),
        (
            {"regions__top__plies": [{"material": "carbon", "thickness": 0.001}]},
            r"f\.regions\.top\.plies: 1 plies are 0\.001 m thick in all, expected the 0\.000762 m",
        ),
        (
            {"regions__top__direction": {"curve": "outside"}},
            r"f\.regions\.top\.direction\.curve = 'outside': the mesh has no such physical curve",
        ),
        ({"regions__top__direction": None}, r"f\.regions\.top\.direction: missing"),
        (
            {"regions__top__direction": {"vektor": [1, 0]}},
            r"expected vector, circle, curve or cells",
        ),
        ({"mesh__degree": 1}, r"f\.mesh\.degree = 1: expected at least 2"),
    ],
)
def test_wrong_descriptions(change: dict[str, Any], message: str) -> None:
    with pytest.raises(SectionError, match=message):
        analyse(changed(**change), "f", estimate=False)
