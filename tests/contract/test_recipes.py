"""The recipes of CONTRIBUTING.md: one new file is enough, and nothing else names a kind."""

import re
from pathlib import Path

import pytest
from source_copy import copy_with, recipe_files, run_python

from plymotion.solver.dynamics.joints.contract import DrivenBy
from plymotion.solver.dynamics.joints.table import JOINTS

# Joints that other files build mechanisms with: virtual bodies, compiling ahead.
USED = {"fixed", "revolute"}

PROGRAMS = Path(__file__).resolve().parent.parent / "recipes"


@pytest.fixture(scope="module")
def copy(repository, tmp_path_factory) -> Path:
    """The sources with all examples of CONTRIBUTING.md."""
    files = recipe_files(repository)
    assert len(files) >= 1
    return copy_with(repository, tmp_path_factory.mktemp("recipes"), files)


def test_a_joint(copy, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "joint.py"), str(tmp_path))
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


def test_a_section_shape(copy, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "section_shape.py"), str(tmp_path))
    page = run_python(copy, repository, "-m", "plymotion.solver.inputs.section.reference")
    assert '### `shape = "square-tube"`' in page
    assert "| `side` | number | m | > 0 | required | outer width and height |" in page


def test_a_criterion(copy, repository):
    run_python(copy, repository, str(PROGRAMS / "criterion.py"))


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
