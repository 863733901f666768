"""FE tests with every coordinate of a mesh changed by one unit of the last digit.

    PYTHONPATH=.:tools python3 -m pytest -p last_digit tests/fe/test_section_twist.py

A test that passes without this plugin of pytest and fails with it compares rounding errors, as it
would on another processor: the comparison needs a floor from the scale of the data.
LAST_DIGIT=NUMBER draws other changes. Meshes are changed where sections and shells read them, a
node as the lines of curves through it. Commands that tests start in other processes are not.
Three tests fail by nature, because they ask for the coordinates of the file itself:
test_a_coordinate_that_is_no_number_is_named, test_section_user_meshes.py::test_arrays and
test_results_are_in_the_order_of_the_mesh_file.
"""

import os
from dataclasses import replace
from typing import Any

import numpy as np

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.space import section_mesh as sections

DRAW = np.uint64(2 * int(os.environ.get("LAST_DIGIT", "0")) + 1)
MIXERS = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)


def changed(points: Any) -> Any:
    """Return points (..., 2 or 3), each coordinate up or down by what the whole point decides."""
    points = np.ascontiguousarray(points, dtype=float)
    with np.errstate(over="ignore"):
        drawn: Any = DRAW * np.uint64(MIXERS[0])
        for column, mixer in zip(np.moveaxis(points + 0.0, -1, 0), MIXERS, strict=False):
            drawn = (drawn ^ np.ascontiguousarray(column).view(np.uint64)) * np.uint64(mixer)
            drawn = drawn ^ (drawn >> np.uint64(29))
    up = (drawn[..., None] >> np.arange(40, 40 + points.shape[-1], dtype=np.uint64)) & np.uint64(1)
    moved = np.nextafter(points, np.where(up == 1, np.inf, -np.inf))
    return np.where(points == 0.0, points, moved)


def _changed(mesh: Any) -> Any:
    curves = {name: changed(lines) for name, lines in getattr(mesh, "curves", {}).items()}
    more = {"curves": curves} if curves else {}
    return replace(mesh, points=changed(mesh.points), **more)


_surface, _arrays, _mixed = fenicsx.surface_mesh, sections._arrays, sections._mixed_arrays


def _of_mixed(path: Any) -> Any:
    mesh = _mixed(path)
    return None if mesh is None else _changed(mesh)


fenicsx.surface_mesh = lambda *words, **more: _changed(_surface(*words, **more))
vars(sections).update(_arrays=lambda path: _changed(_arrays(path)), _mixed_arrays=_of_mixed)
