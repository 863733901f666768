"""The one list of codes of findings: complete, true to the source, and each code provoked."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from plymotion.solver.results.codes import CODES, GROUPS, RUN_CODES
from plymotion.solver.results.codes.page import warnings_page

# Where the number of a code is kept, for those whose source does not read it from the list.
LIMITS = {
    "feedback-limits-steps": ("solver/integrators/generic/advice.py", "FEEDBACK_LIMITED"),
    "mesh-coarse-for-modes": ("preprocess/beam/accuracy.py", "LIMIT"),
    "static-modes-dependent": ("preprocess/modes/static.py", "DEPENDENT"),
    "measured-shape-rigid": ("solver/commands/measured_modes/shapes.py", "RIGID"),
    "measured-modal-mass": ("solver/commands/measured_modes/shapes.py", "SCALED"),
    "measured-shapes-coupled": ("solver/commands/measured_modes/shapes.py", "COUPLED"),
    "sliver": ("preprocess/shell/guards.py", "SLIVER"),
    "nodes-not-merged": ("preprocess/shell/guards.py", "COINCIDENT"),
    "cst-in-plane-bending": ("preprocess/shell/guards.py", "ACROSS"),
    "dst-thick": ("preprocess/shell/plates/dst.py", "SHEAR_RATIO_LIMIT"),
    "laminate-unsymmetric": ("preprocess/laminate/report.py", "COUPLED"),
    "buckling-after-large-rotation": ("preprocess/shell/prestress.py", "LARGE"),
    "laminate-unbalanced": ("preprocess/laminate/report.py", "COUPLED"),
    "laminate-soft-core": ("preprocess/laminate/report.py", "SOFT"),
    "unmerged-nodes": ("preprocess/section/mesh_checks.py", "COINCIDENT"),
    "sliver-elements": ("preprocess/section/mesh_checks.py", "LEAST_SINE"),
    "nearly-incompressible": ("preprocess/section/guards.py", "INCOMPRESSIBLE"),
    "ill-conditioned": ("preprocess/section/problem.py", "LARGEST_GROWTH"),
    "stress-at-corner": ("solver/package/section/corners.py", "ANGLE_DEG"),
    "direction-reverses": ("preprocess/section/guards.py", "REVERSAL"),
    "strongly-curved": ("preprocess/section/shape_along.py", "STRONG"),
    "taper-neglected": ("preprocess/section/shape_along.py", "TAPER"),
    "accuracy-not-met": ("preprocess/section/analysis.py", "MOST_DOFS"),
}
MAKERS = {"_warning", "add_warning"}  # functions that take a code first


def trees(folder: Path) -> Iterator[tuple[Path, ast.AST]]:
    for path in sorted(folder.rglob("*.py")):
        yield path, ast.parse(path.read_text("utf-8"))


def written_codes(tree: ast.AST) -> Iterator[str]:
    """Codes that a source writes as text: {"code": TEXT}, or the first argument of MAKERS."""
    for node in ast.walk(tree):
        found: list[ast.expr | None] = []
        if isinstance(node, ast.Dict):
            pairs = zip(node.keys, node.values, strict=True)
            found = [v for k, v in pairs if isinstance(k, ast.Constant) and k.value == "code"]
        elif isinstance(node, ast.Call) and node.args:
            function = node.func
            name = getattr(function, "attr", getattr(function, "id", ""))
            found = [node.args[0]] if name in MAKERS else []
        for value in found:
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield value.value


def test_codes_are_told_apart() -> None:
    names = [code.name for group in GROUPS.values() for code in group]
    assert len(names) == len(set(names)) == len(CODES)


def test_codes_of_the_source_are_those_of_the_list(repository: Path) -> None:
    written = set()
    for half in ("preprocess", "solver"):
        for _, tree in trees(repository / half):
            written |= set(written_codes(tree))
    own = {c.name for group in list(GROUPS.values())[2:] for c in group}
    assert written == own


def test_findings_are_made_from_the_list(repository: Path) -> None:
    """Only results/finding.py makes findings, but for codes of foreign packages."""
    makers = []
    for path, tree in trees(repository / "solver"):
        calls = (n for n in ast.walk(tree) if isinstance(n, ast.Call))
        if any(getattr(call.func, "id", "") == "Finding" for call in calls):
            makers.append(path.relative_to(repository).as_posix())
    assert makers == ["solver/checks/packages.py", "solver/results/finding.py"]


def test_there_is_one_class_finding(repository: Path) -> None:
    found = [
        path.relative_to(repository).as_posix()
        for half in ("preprocess", "solver")
        for path, tree in trees(repository / half)
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and node.name == "Finding"
    ]
    assert found == ["solver/results/finding.py"]


def test_each_code_of_a_run_is_used(repository: Path) -> None:
    """A constant of the list that no source imports is a code that no run can have."""
    used: set[str] = set()
    for path, tree in trees(repository / "solver"):
        if "results/codes" in path.as_posix():
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and "codes" in (node.module or ""):
                used |= {alias.name for alias in node.names}
    from plymotion.solver.results.codes import course, members, motion

    constants = {
        name: value.name
        for module in (course, motion, members)
        for name, value in vars(module).items()
        if value in (*RUN_CODES, *members.CODES) and name.isupper()
    }
    assert len(constants) == len(RUN_CODES) + len(members.CODES)
    assert [code for name, code in constants.items() if name not in used] == []


@pytest.mark.parametrize(("code", "place"), LIMITS.items(), ids=LIMITS)
def test_limits_are_those_of_the_source(
    repository: Path, code: str, place: tuple[str, str]
) -> None:
    path, name = place
    tree = ast.parse((repository / path).read_text("utf-8"))
    assigned = [n for n in ast.walk(tree) if isinstance(n, ast.Assign)]
    (value,) = (
        n.value for n in assigned if isinstance(n.targets[0], ast.Name) and n.targets[0].id == name
    )
    assert ast.literal_eval(value) == CODES[code].limit


def test_limits_of_packages_are_all_compared() -> None:
    own = [c for group in list(GROUPS.values())[2:] for c in group]
    assert {c.name for c in own if c.limit == c.limit} <= set(LIMITS)


def test_each_code_is_provoked_by_a_test(repository: Path) -> None:
    """By the mark `provokes`, on a test that names it."""
    provoked: set[str] = set()
    for _, tree in trees(repository / "tests"):
        for node in ast.walk(tree):
            if not isinstance(node, ast.FunctionDef):
                continue
            for mark in node.decorator_list:
                if isinstance(mark, ast.Call) and getattr(mark.func, "attr", "") == "provokes":
                    names = [ast.literal_eval(argument) for argument in mark.args]
                    words = ast.unparse(node.body)  # type: ignore[arg-type]
                    assert all(repr(name) in words for name in names), (node.name, names)
                    provoked |= set(names)
    assert provoked <= set(CODES)
    missing = sorted(set(CODES) - provoked)
    assert not missing, missing


def test_page_is_fresh(repository: Path) -> None:
    page = repository / "docs" / "warnings.md"
    assert page.is_file(), "run `make docs`"
    assert page.read_text("utf-8") == warnings_page(), "stale: run `make docs`"
