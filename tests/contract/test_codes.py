"""The one list of codes of findings: complete, true to the source, and each code provoked."""

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from plymotion.solver.results import codes
from plymotion.solver.results.codes import CODES, GROUPS, MEMBER_CODES, RUN_CODES

# Where the number of a code is kept, for those whose source does not read it from the list.
LIMITS = {
    "feedback-limits-steps": ("solver/integrators/generic/advice.py", "FEEDBACK_LIMITED"),
    "breaks-not-searched": ("solver/integrators/breakpoints.py", "MOST_CELLS"),
    "mesh-coarse-for-modes": ("preprocess/beam/beam_body.py", "LIMIT"),
    "modes-not-counted": ("preprocess/solid/model.py", "MOST_FACTORISED"),
    "solid-mesh-coarse": ("preprocess/solid/tolerances.py", "COARSE"),
    "static-modes-dependent": ("preprocess/modes/reduced.py", "DEPENDENT"),
    "measured-shape-rigid": ("solver/package/body/measured.py", "RIGID"),
    "measured-modal-mass": ("solver/package/body/measured.py", "SCALED"),
    "measured-shapes-coupled": ("solver/package/body/measured.py", "COUPLED"),
    "sliver": ("preprocess/shell/model/shell_warnings.py", "SLIVER"),
    "nodes-not-merged": ("preprocess/shell/model/shell_warnings.py", "COINCIDENT"),
    "cst-in-plane-bending": ("preprocess/shell/model/shell_warnings.py", "ACROSS"),
    "dst-thick": ("preprocess/shell/elements/plates/dst.py", "SHEAR_RATIO_LIMIT"),
    "laminate-unsymmetric": ("preprocess/laminate/report.py", "COUPLED"),
    "shell-mesh-coarse": ("preprocess/shell/analyses/modes.py", "COARSE"),
    "shell-triangles-warped": ("preprocess/shell/model/states.py", "LOCKED"),
    "shell-quadrilaterals-warped": ("preprocess/shell/model/states.py", "LOCKED"),
    "link-distorts-section": ("preprocess/shell/model/states.py", "DISTORTED"),
    "triangles-not-paired": ("preprocess/shell/model/shell_warnings.py", "UNPAIRED"),
    "buckling-after-large-rotation": ("preprocess/shell/analyses/buckling.py", "LARGE"),
    "buckles-in-plane": ("preprocess/shell/analyses/buckling.py", "IN_PLANE"),
    "laminate-unbalanced": ("preprocess/laminate/report.py", "COUPLED"),
    "laminate-soft-core": ("preprocess/laminate/report.py", "SOFT"),
    "unmerged-nodes": ("preprocess/section/space/mesh_checks.py", "COINCIDENT"),
    "sliver-elements": ("preprocess/section/space/mesh_checks.py", "LEAST_SINE"),
    "nearly-incompressible": ("preprocess/section/section_warnings.py", "INCOMPRESSIBLE"),
    "ill-conditioned": ("preprocess/section/section_problem.py", "LARGEST_GROWTH"),
    "coarse-mesh": ("preprocess/section/section_warnings.py", "COARSE"),
    "stress-at-corner": ("solver/package/section/stress.py", "ANGLE_DEG"),
    "direction-reverses": ("preprocess/section/section_warnings.py", "REVERSAL"),
    "strongly-curved": ("preprocess/section/section_warnings.py", "STRONG"),
    "taper-neglected": ("preprocess/section/section_warnings.py", "TAPER"),
    "rule-differs": ("solver/extras/blade/tables.py", "AGREE"),
    "no-room": ("solver/extras/blade/analysis.py", "REMOVED"),
    "differs-from-file": ("solver/extras/blade/windio.py", "DIFFERENT"),
    "accuracy-not-met": ("preprocess/section/section_analysis.py", "MOST_DOFS"),
    "verification-differs": ("preprocess/section/section_verification.py", "LARGEST"),
}
MAKERS = {"_warning", "add_warning", "coded"}  # functions that take a code first


@dataclass
class Facts:
    """What the tests ask of one source file.

    Attributes
    ----------
    codes : that it writes as text
    makes : it calls Finding(...)
    defines : it has a class Finding
    imports : names that it imports from a module of codes
    """

    codes: set[str] = field(default_factory=set)
    makes: bool = False
    defines: bool = False
    imports: set[str] = field(default_factory=set)


@pytest.fixture(scope="module")
def facts(repository: Path) -> dict[str, Facts]:
    """The facts of each file of both halves, by its path."""
    files = [f for half in ("preprocess", "solver") for f in (repository / half).rglob("*.py")]
    return {f.relative_to(repository).as_posix(): facts_of(f) for f in sorted(files)}


def facts_of(path: Path) -> Facts:
    text = path.read_text("utf-8")
    if not any(word in text for word in ("code", "Finding", *MAKERS)):
        return Facts()  # without the words that are looked for: it need not be parsed
    nodes = list(ast.walk(ast.parse(text)))
    found = Facts(set(written_codes(nodes)))
    for node in nodes:
        if isinstance(node, ast.Call):
            found.makes |= getattr(node.func, "id", "") == "Finding"
        elif isinstance(node, ast.ClassDef):
            found.defines |= node.name == "Finding"
        elif isinstance(node, ast.ImportFrom) and "codes" in (node.module or ""):
            found.imports |= {alias.name for alias in node.names}
    return found


def written_codes(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Codes that a source writes as text: {"code": TEXT}, or the first argument of MAKERS."""
    for node in nodes:
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


def test_codes_of_the_source_are_those_of_the_list(facts: dict[str, Facts]) -> None:
    written = set().union(*(fact.codes for fact in facts.values()))
    own = {c.name for group in list(GROUPS.values())[2:] for c in group}
    assert written == own


def test_findings_are_made_from_the_list(facts: dict[str, Facts]) -> None:
    """Only results/codes.py makes findings, but for codes of foreign packages."""
    makers = [path for path, fact in facts.items() if fact.makes and path.startswith("solver/")]
    assert makers == ["solver/checks/balances.py", "solver/results/codes.py"]


def test_there_is_one_class_finding(facts: dict[str, Facts]) -> None:
    assert [path for path, fact in facts.items() if fact.defines] == ["solver/results/codes.py"]


def test_each_code_of_a_run_is_used(facts: dict[str, Facts]) -> None:
    """A constant of the list that no source imports is a code that no run can have."""
    used: set[str] = set()
    for path, fact in facts.items():
        if path.startswith("solver/") and "results/codes" not in path:
            used |= fact.imports
    constants = {
        name: value.name
        for name, value in vars(codes).items()
        if value in (*RUN_CODES, *MEMBER_CODES) and name.isupper()
    }
    assert len(constants) == len(RUN_CODES) + len(MEMBER_CODES)
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
    texts = (path.read_text("utf-8") for path in (repository / "tests").rglob("*.py"))
    for text in texts:
        if "provokes" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
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


@pytest.mark.parametrize("title", GROUPS)
def test_page_has_the_codes_of_the_list_with_level_limit_and_words(
    repository: Path, title: str
) -> None:
    page = (repository / "docs" / "warnings.md").read_text("utf-8")
    section = page.split(f"\n## {title}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("| `")]
    rows = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    expected = [(f"`{code.name}`", code.level) for code in GROUPS[title]]
    assert [(row[0], row[1]) for row in rows] == expected
    for code, (_, _, meaning, threshold, remedy) in zip(GROUPS[title], rows, strict=True):
        assert min(map(len, (meaning, threshold, remedy))) > 3, code
        if code.limit == code.limit:
            assert f"{code.limit:g}" in re.split(r"[\s,;]+", threshold), code


def test_page_has_no_other_table(repository: Path) -> None:
    page = (repository / "docs" / "warnings.md").read_text("utf-8")
    assert [line for line in page.splitlines() if line.startswith("## ")] == [
        f"## {title}" for title in GROUPS
    ]
