"""Recipes of CONTRIBUTING.md that need FEniCSx: a new section shape is meshed and solved."""

from pathlib import Path

import pytest
from harness.source_copy import copy_with_recipes, run_python

PROGRAMS = Path(__file__).resolve().parent.parent / "recipes"


@pytest.mark.one_end
def test_a_section_shape(tmp_path: Path) -> None:
    repository = PROGRAMS.parent.parent
    copy = copy_with_recipes(repository, tmp_path)
    run_python(copy, repository, str(PROGRAMS / "section_stiffness.py"))
