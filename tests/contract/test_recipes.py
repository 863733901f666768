"""The recipes of CONTRIBUTING.md: one new file is enough, and nothing else names a kind."""

import ast
import re
from pathlib import Path

import pytest
from harness.source_copy import copy_with_recipes, recipe_files, recipe_lines, run_python

from plymotion.solver.dynamics.elements.forces.table import FORCES
from plymotion.solver.dynamics.elements.joints.contract import DrivenBy
from plymotion.solver.dynamics.elements.joints.table import JOINTS
from plymotion.solver.inputs.case.tables.solver import Solver
from plymotion.solver.integrators.table import INTEGRATORS
from plymotion.solver.package.shell import elements

# Joints that other files build mechanisms with: virtual bodies, compiling ahead; and a word that is
# also a measure of expressions.
USED = {"fixed", "revolute", "distance"}

DESCRIBED = """
from pydantic import ValidationError
from plymotion.solver.inputs.shell import Elements

assert Elements(plate="centroid").plate == "centroid"
try:
    Elements(plate="centroids")
except ValidationError as error:
    assert "'centroid'" in str(error), error
else:
    raise AssertionError
"""
KEYS = "from plymotion.solver.inputs import manual; print(*manual.page_keys('{}'), sep='\\n')"
PROGRAMS = Path(__file__).resolve().parent.parent / "recipes"


@pytest.fixture(scope="module")
def copy(repository, tmp_path_factory) -> Path:
    """The sources with all examples of CONTRIBUTING.md."""
    assert len(recipe_files(repository)) == 8
    assert len(recipe_lines(repository)) == 1
    return copy_with_recipes(repository, tmp_path_factory.mktemp("recipes"))


@pytest.fixture(scope="module")
def page(copy, repository) -> str:
    """The reference page of case files with all examples."""
    return run_python(copy, repository, "-m", "plymotion.solver", "check", "--reference")


def test_a_joint(copy, page, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "joint.py"), str(tmp_path))
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


def test_a_force_element(copy, page, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "force_element.py"), str(tmp_path))
    assert '## `[forces.NAME]` with kind = "cubic_spring": a force that grows' in page
    assert "| `strength` | number | N/m3 | >= 0 | required | k in k s^3 |" in page


def test_a_section_shape(copy, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "section_shape.py"), str(tmp_path))
    page = run_python(copy, repository, "-c", KEYS.format("section"))
    assert '### `shape = "square-tube"`' in page
    assert "| `side` | number | m | > 0 | required | outer width and height |" in page


def test_a_criterion(copy, repository):
    run_python(copy, repository, str(PROGRAMS / "criterion.py"))


def test_a_signal(copy, page, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "signal_of_a_place.py"), str(tmp_path))
    assert "specific_force [m/s2]: acceleration less gravity, interface axes" in page


def test_a_shell_element(copy, repository):
    """In descriptions and their manual; tests/fe/test_shell_recipe.py computes with it."""
    run_python(copy, repository, "-c", DESCRIBED)
    page = run_python(copy, repository, "-c", KEYS.format("shell"))
    assert "centroid is linear, with the shear strain of its centroid" in page


def test_an_export_format(copy, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "export_format.py"), str(tmp_path))


def test_an_integrator(copy, page, repository, tmp_path):
    run_python(copy, repository, str(PROGRAMS / "integrator.py"), str(tmp_path))
    assert "heun: explicit, of order 2" in page
    assert "| `corrections` | integer |  | >= 1, <= 9 | `1` | of heun in a step |" in page
    tests = str(repository / "tests/unit/test_integrators_contract.py")
    run = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "heun", tests)
    printed = run_python(copy, repository, *run)
    assert re.search(r"\b\d+ passed", printed), printed
    assert "failed" not in printed


def test_the_page_on_shells_has_a_line_for_each_element(repository):
    page = (repository / "docs/shells.md").read_text("utf-8")
    for name in (*elements.PLATES, *elements.MEMBRANES):
        assert page.count(f"\n| `{name}` | ") == 1, name
    for name in elements.DRILLINGS:
        assert f"`{name}` (" in page, name


@pytest.fixture(scope="module")
def files_with(repository) -> dict[str, list[str]]:
    """Name of an integrator -> files that have it as a constant, once for each time."""
    found = {name: [] for name in INTEGRATORS}
    for file in (repository / "solver").rglob("*.py"):
        text = file.read_text("utf-8")
        if not any(name in text for name in INTEGRATORS):
            continue  # parsing takes longer
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Constant) and node.value in INTEGRATORS:
                found[node.value].append(file.relative_to(repository).as_posix())
    return found


@pytest.mark.parametrize("name", INTEGRATORS)
def test_one_source_file_names_an_integrator(files_with, name):
    """Besides the default of the case file; messages may recommend one in their text."""
    found = list(files_with[name])
    if name == Solver.model_fields["integrator"].default:
        found.remove("solver/inputs/case/tables/solver.py")
    assert len(found) == 1, found


def test_the_page_on_integrators_names_each_one(repository):
    page = (repository / "docs/integrators.md").read_text("utf-8")
    assert not [name for name in INTEGRATORS if f"`{name}`" not in page]


@pytest.fixture(scope="module")
def texts(repository) -> dict[str, str]:
    """All sources."""
    sources = [*(repository / "solver").rglob("*.py"), *(repository / "preprocess").rglob("*.py")]
    return {file.relative_to(repository).as_posix(): file.read_text("utf-8") for file in sources}


@pytest.mark.parametrize("kind", sorted(set(JOINTS) - USED))
def test_one_source_file_names_a_joint(texts, kind):
    quoted = re.compile(rf"""["']{kind}["']""")
    found = [name for name, text in texts.items() if quoted.search(text)]
    assert found == [f"solver/dynamics/elements/joints/{kind}.py"]


@pytest.mark.parametrize("kind", sorted(set(FORCES) - {"force"}))
def test_one_source_file_names_a_force_element(texts, kind):
    """`force` is also a quantity of a signal."""
    quoted = re.compile(rf"""["']{kind}["']""")
    solver = (item for item in texts.items() if item[0].startswith("solver/"))
    found = [name for name, text in solver if quoted.search(text)]
    assert len(found) == 1, found
    assert found[0].startswith("solver/dynamics/elements/forces/")


def test_the_page_on_forces_has_a_line_for_each_force_element(repository):
    page = (repository / "docs/forces.md").read_text("utf-8")
    rows = "\n".join(re.findall(r"^\| .*$", page, re.M))
    assert not [kind for kind in FORCES if f"`{kind}`" not in rows]


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
