"""The recipes of CONTRIBUTING.md: one new file is enough, and nothing else names a kind."""

import re
from pathlib import Path

import pytest
from source_copy import copy_with, recipe_files, run_python

from plymotion.solver.dynamics.joints.contract import DrivenBy
from plymotion.solver.dynamics.joints.table import JOINTS

# Joints that other files build mechanisms with: virtual bodies, compiling ahead.
USED = {"fixed", "revolute"}

JOINT_CASE = """
import sys
from pathlib import Path

import numpy as np
from case_samples import rigid, run_text

import plymotion
from plymotion.solver.errors import InputError

folder = Path(sys.argv[1])
assert plymotion.__file__.startswith(str(Path.cwd())), plymotion.__file__
text = (
    "gravity = [0.0, 0.0, -9.81]\\n[ground.O]\\nposition = [0.0, 0.0, 0.0]\\n"
    + rigid("ball", 2.0, 0.1, {"a": (0, 0, 0)}, position=(1, 0, 0))
    + '[joints.floor]\\nkind = "point_on_plane"\\nbetween = ["ground.O", "ball.a"]\\n'
    + "axis = [0.0, 1.0, 1.0]\\n"
    + '[signals.y]\\nkind = "position"\\nat = "ball.a"\\ncomponent = "y"\\n'
    + '[signals.own]\\nkind = "joint"\\njoint = "floor"\\ncoordinate = "x"\\n'
    + '[signals.push]\\nkind = "reaction"\\njoint = "floor"\\nquantity = "force"\\n'
    + 'component = "magnitude"\\n'
)
t, s, _ = run_text(folder, text, t_end=1.0, step=0.1)
# Down the plane of 45 degrees with g / sqrt(2); its y component is half of g.
np.testing.assert_allclose(s["y"], 0.5 * 0.5 * 9.81 * t**2, atol=1e-9)
np.testing.assert_allclose(s["push"], 2.0 * 9.81 / np.sqrt(2.0), rtol=1e-9)
assert s["own"][0] == 0.0
try:
    run_text(folder, text.replace("axis =", "axes ="), t_end=1.0, step=0.1)
except InputError as error:
    assert "joints.floor.axes: unknown key; did you mean 'axis'" in str(error), error
else:
    raise AssertionError("an unknown key was accepted")
"""


@pytest.fixture(scope="module")
def copy(repository, tmp_path_factory) -> Path:
    """The sources with all examples of CONTRIBUTING.md."""
    files = recipe_files(repository)
    assert len(files) >= 1
    return copy_with(repository, tmp_path_factory.mktemp("recipes"), files)


def test_a_joint(copy, repository, tmp_path):
    run_python(copy, repository, "-c", JOINT_CASE, str(tmp_path))
    page = run_python(copy, repository, "-m", "plymotion.solver", "check", "--reference")
    assert '## `[joints.NAME]` with kind = "point_on_plane": the second place in a plane' in page
    tests = str(repository / "tests/verification/test_joints.py")
    printed = run_python(
        copy,
        repository,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "-k",
        "point_on_plane",
        tests,
    )
    assert re.search(r"\b[3-9] passed", printed), printed


@pytest.mark.parametrize("kind", sorted(set(JOINTS) - USED))
def test_one_source_file_names_a_joint(repository, kind):
    quoted = re.compile(rf"""["']{kind}["']""")
    sources = [*(repository / "solver").rglob("*.py"), *(repository / "preprocess").rglob("*.py")]
    found = [
        file.relative_to(repository).as_posix()
        for file in sources
        if quoted.search(file.read_text("utf-8"))
    ]
    assert found == [f"solver/dynamics/joints/{kind}.py"]


def test_the_page_on_mechanisms_has_a_line_for_each_joint(repository):
    """docs/mechanisms.md: kind, rows, what it leaves free, coordinates, drives."""
    page = (repository / "docs/mechanisms.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (\d) \|[^|]*\|([^|]*)\|([^|]*)\|$", page, re.M)
    found = {
        kind: (int(n), re.findall("`(.*?)`", free), re.findall("`(.*?)`", drives))
        for kind, n, free, drives in rows
    }
    assert found == {
        kind: (
            len(joint.units),
            [coordinate.name for coordinate in joint.coordinates],
            [key.name for key in joint.keys if isinstance(key, DrivenBy)],
        )
        for kind, joint in JOINTS.items()
    }
