"""Walls along a polyline that do not fit together, each named; plies give the thickness."""

from pathlib import Path
from typing import Any

import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section.specification import section_spec


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x3": [0.0, 0.1]}, "mesh.x3: 2 numbers, expected 3, as in x2"),
        ({"x2": [0.0, 0.0, 0.0], "x3": [0.0, 0.0, 0.1]}, "expected different neighbouring points"),
        ({"wall": [0.001, 0.002, 0.003]}, "one thickness, or one for each of 2 walls"),
        ({"x2": [0.0, 0.1, 0.05], "x3": [0.0, 0.0, 0.0]}, "wall-1 and wall-2 are in one line"),
        ({"x2": [0.0, 0.1, 0.0], "x3": [0.0, 0.0, 0.001]}, "too short for the corners"),
        (
            {"x2": [0.0, 0.1, 0.1, 0.05, 0.05], "x3": [0.0, 0.0, 0.1, 0.1, -0.1]},
            "wall-1 and wall-4 touch each other",
        ),
    ],
)
def test_walls_that_do_not_fit_are_named(change: dict[str, Any], message: str) -> None:
    mesh = {"shape": "polyline", "x2": [0.0, 0.1, 0.1], "x3": [0.0, 0.0, 0.1], "wall": 0.002}
    table: dict[str, Any] = {
        **{"format": 1, "title": "walls", "mesh": {**mesh, **change}},
        "materials": {"m": {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}},
        "regions": {"all": {"material": "m"}},
    }
    with pytest.raises(InputError, match=message):
        section_spec(table, Path("walls.toml"))


def test_the_plies_of_each_wall_give_its_thickness() -> None:
    mesh = {"shape": "polyline", "x2": [0.0, 0.1, 0.1], "x3": [0.0, 0.0, 0.1]}
    laminates = {
        name: {"material": "m", "layup": layup, "ply_thickness": 0.00025}
        for name, layup in (("flange", "[0_4]s"), ("web", "[45/-45]s"))
    }
    table: dict[str, Any] = {
        **{"format": 1, "title": "walls", "laminates": laminates, "convention": "contour"},
        "materials": {"m": {"library": "as4-3501-6", "rho": 1580.0}},
        "regions": {"wall-1": {"laminate": "flange"}, "wall-2": {"laminate": "web"}},
    }
    file = Path("walls.toml")
    found = section_spec({**table, "mesh": mesh}, file)
    assert found == section_spec({**table, "mesh": {**mesh, "wall": [0.002, 0.001]}}, file)
    with pytest.raises(InputError, match=r"regions\.wall-2: its 4 plies are 0\.001 m thick in all"):
        section_spec({**table, "mesh": {**mesh, "wall": 0.002}}, file)
