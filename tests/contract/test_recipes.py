"""The recipes of CONTRIBUTING.md: one new file is enough, and nothing else names a kind."""

import ast
import json
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

PROGRAMS = Path(__file__).resolve().parent.parent / "recipes"
NAMES = [file.stem for file in sorted(PROGRAMS.glob("*.py"))]
OF_FENICSX = ("shell_element", "section_stiffness")  # tests/fe runs them

# Runs programs, each with a folder of its own, and prints what went wrong in each, and all pages.
EACH = """
import contextlib, io, json, runpy, sys, tempfile, traceback
from pathlib import Path
from pydantic import ValidationError
from plymotion.solver.__main__ import main
from plymotion.solver.inputs import manual
from plymotion.solver.inputs.shell import Elements

folder, *programs = sys.argv[1:]
wrong = {}
for program in programs:
    sys.argv[1:] = [tempfile.mkdtemp(dir=folder)]
    wrong[Path(program).stem] = ""
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            runpy.run_path(program, run_name="__main__")
    except BaseException:
        wrong[Path(program).stem] = traceback.format_exc()
with contextlib.redirect_stdout(io.StringIO()) as page:
    assert main(["check", "--reference"]) == 0
pages = {name: "\\n".join(manual.page_keys(name)) for name in ("section", "shell")}
assert Elements(plate="centroid").plate == "centroid"
try:
    Elements(plate="centroids")
except ValidationError as error:
    assert "'centroid'" in str(error), error
else:
    raise AssertionError
print(json.dumps([wrong, {"case": page.getvalue(), **pages}]))
"""


@pytest.fixture(scope="module")
def copy(repository, tmp_path_factory) -> Path:
    """The sources with all examples of CONTRIBUTING.md."""
    assert len(recipe_files(repository)) == 8
    assert len(recipe_lines(repository)) == 1
    return copy_with_recipes(repository, tmp_path_factory.mktemp("recipes"))


@pytest.fixture(scope="module")
def followed(copy, repository, tmp_path_factory) -> tuple[dict[str, str], dict[str, str]]:
    """What went wrong in each program, and the reference pages, with all examples."""
    files = [str(PROGRAMS / f"{name}.py") for name in NAMES if name not in OF_FENICSX]
    printed = run_python(copy, repository, "-c", EACH, str(tmp_path_factory.mktemp("runs")), *files)
    return json.loads(printed.splitlines()[-1])


@pytest.fixture(scope="module")
def passed(copy, repository) -> str:
    """The tests of all joints and integrators, of which those of the examples passed."""
    files = ("verification/test_joints.py", "unit/test_integrators_contract.py")
    tests = [str(repository / "tests" / file) for file in files]
    words = ("-m", "pytest", "-q", "-rp", "-p", "no:cacheprovider", "-k", "point_on_plane or heun")
    return run_python(copy, repository, *words, *tests)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in OF_FENICSX])
def test_the_example_does_what_its_program_asserts(followed, name):
    wrong, _ = followed
    assert wrong[name] == ""


@pytest.mark.parametrize(
    ("page", "lines"),
    [
        (
            "case",
            [
                '## `[joints.NAME]` with kind = "point_on_plane": the second place in a plane',
                '## `[forces.NAME]` with kind = "cubic_spring": a force that grows',
                "| `strength` | number | N/m3 | >= 0 | required | k in k s^3 |",
                "specific_force [m/s2]: acceleration less gravity, interface axes",
                "heun: explicit, of order 2",
                "| `corrections` | integer |  | >= 1, <= 9 | `1` | of heun in a step |",
            ],
        ),
        (
            "section",
            [
                '### `shape = "square-tube"`',
                "| `side` | number | m | > 0 | required | outer width and height |",
            ],
        ),
        # Of descriptions and their manual; tests/fe/test_shell_recipe.py computes with it.
        ("shell", ["centroid is linear, with the shear strain of its centroid"]),
    ],
)
def test_the_manual_has_the_examples(followed, page, lines):
    _, pages = followed
    assert [line for line in lines if line not in pages[page]] == []


@pytest.mark.parametrize(
    ("file", "least", "most"), [("test_joints", 3, 9), ("test_integrators_contract", 1, 99)]
)
def test_the_tests_of_a_folder_find_the_example(passed, file, least, most):
    assert least <= len(re.findall(rf"^PASSED \S*{file}\.py::", passed, re.M)) <= most
    assert re.search(r"\d+ failed", passed) is None


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


def test_the_page_on_joints_has_a_line_for_each_joint(repository):
    """docs/joints.md: kind, rows, what it leaves free, coordinates, drives."""
    page = (repository / "docs/joints.md").read_text("utf-8")
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
