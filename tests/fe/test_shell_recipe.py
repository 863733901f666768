"""The recipe of a shell element in CONTRIBUTING.md: one new file in UFL is enough."""

import shutil
from pathlib import Path

import pytest
from harness.source_copy import copy_with_recipes, run_python

pytestmark = pytest.mark.one_end

REPOSITORY = Path(__file__).resolve().parent.parent.parent
REFUSED = """
try:
    import plymotion.preprocess.shell.elements.plates
except ValueError as error:
    print(error)
"""


@pytest.fixture
def copy(tmp_path) -> Path:
    return copy_with_recipes(REPOSITORY, tmp_path)


def test_its_rigid_motions_shear_and_order(copy) -> None:
    run_python(copy, REPOSITORY, str(REPOSITORY / "tests/recipes/shell_element.py"))


def test_without_its_line_it_is_refused(copy) -> None:
    file = "solver/package/shell/elements.py"
    shutil.copy(REPOSITORY / file, copy / file)
    message = run_python(copy, REPOSITORY, "-c", REFUSED)
    assert "plates: the files supply ['centroid', 'dkmt', 'dkt', 'dst', 'mitc3']" in message
