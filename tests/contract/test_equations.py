"""The paper's equations: each in the code or with a reason, and the map is fresh."""

from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="module")
def equations(tools: Path) -> ModuleType:
    import equations

    return equations


def test_every_equation_has_code_or_a_reason(equations: ModuleType) -> None:
    code = equations.places()
    _, reasons = equations.titles_and_reasons()
    lost = [n for n in range(1, equations.LAST + 1) if n not in code and n not in reasons]
    assert not lost, f"no docstring says `Paper: Eq. (n)` and docs/equations.toml no reason: {lost}"
    stale = sorted(code.keys() & reasons.keys())
    assert not stale, f"in the code now, remove the reasons from docs/equations.toml: {stale}"


def test_every_equation_has_a_title(equations: ModuleType) -> None:
    titles, _ = equations.titles_and_reasons()
    assert sorted(titles) == list(range(1, equations.LAST + 1))


def test_map_is_fresh(equations: ModuleType, repository: Path) -> None:
    page = repository / "docs" / "equations.md"
    assert page.is_file(), "run `make docs`"
    assert page.read_text("utf-8") == equations.table(), "stale: run `make docs`"


@pytest.mark.parametrize(
    ("docstring", "expected"),
    [
        ("One. Paper: Eq. (2).", [2]),
        ("Paper: Eq. (2), Eq. (15). More text (3).", [2, 15]),
        ("Paper: Eq. (36)-(38) and Eq. (45)", [36, 37, 38, 45]),
        ("Paper: Eq. (1),\n    Eq. (3), and Eq. (5)", [1, 3, 5]),
        ("Eq. (7) without the mark, and Paper in prose", []),
    ],
)
def test_grammar(equations: ModuleType, docstring: str, expected: list[int]) -> None:
    assert list(equations.marked(docstring, "here.py:1")) == expected


@pytest.mark.parametrize(
    "docstring",
    [
        "Paper: Equation (2)",
        "Paper: eq. (2)",
        "Paper: Eqs. (2)-(4)",
        "Paper: Eq. (2), (15)",
        "Paper: Eq. (2) and (15)",
        "Paper: Eq. (2) - (4)",
        "Paper: Eq. (46)",
        "Paper: Eq. (0)",
    ],
)
def test_other_forms_are_refused(equations: ModuleType, docstring: str) -> None:
    with pytest.raises(equations.GrammarError, match=r"here\.py:1"):
        list(equations.marked(docstring, "here.py:1"))


def test_tests_are_found_by_use_and_by_number(equations: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "solver").mkdir()
    (tmp_path / "tests").mkdir()
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "equations.toml").write_text('[titles]\n3 = "energy"\n')
    (tmp_path / "solver" / "energy.py").write_text(
        'def strain(w):\n    """Paper: Eq. (3)."""\n    return w @ w\n'
    )
    (tmp_path / "tests" / "test_a.py").write_text(
        "from plymotion.solver.energy import strain\n"
        "def test_use():\n    assert strain\n"
        "def test_number():\n    # Eq. (3) by hand\n    pass\n"
        "def test_other():\n    pass\n"
    )
    row = next(line for line in equations.table(tmp_path).splitlines() if "| energy |" in line)
    assert "solver/energy.py (strain)" in row
    assert "test_use" in row
    assert "test_number" in row
    assert "test_other" not in row
