"""Paths and functions that the documents name exist in the repository."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness.source_copy import recipe_files

FOLDERS = ("solver", "preprocess", "tests", "benchmarks", "tools", "meshes", "cases", "docs")
# Not part of a longer path, such as a dataset `/modal_package/...` or `build/solver/...`.
PATH = re.compile(rf"(?<![\w./-])(?:{'|'.join(FOLDERS)})/[\w./*<>-]*")
LINK = re.compile(r"\]\(([^)#:\s]+)(?:#([\w-]+))?\)")
ANCHOR = re.compile(r"\]\(#([\w-]+)\)")
FUNCTION = re.compile(r"`(\w+)` (?:in |\()`((?:solver|preprocess)/[\w/]+\.py)`")
PLACEHOLDERS = ("<", "NAME", "CASE")


def documents(repository: Path) -> list[Path]:
    """Pages in the form of Markdown."""
    pages = [*repository.glob("*.md"), *repository.glob("docs/**/*.md")]
    return sorted(page for page in pages if page.is_file())


def named_paths(text: str) -> Iterator[str]:
    """Paths of the repository in a text, without what follows them."""
    for match in PATH.finditer(text):
        path = match[0].split("::")[0].rstrip(".-")
        if not any(mark in path for mark in PLACEHOLDERS):
            yield path


def exists(repository: Path, path: str) -> bool:
    """A file, a folder, a pattern with *, or a decision by its number (docs/adr/0002)."""
    if re.fullmatch(r"docs/adr/\d{4}", path):
        path += "-*.md"
    return any(repository.glob(path.rstrip("/")))


def defined(file: Path) -> set[str]:
    """Functions and classes at the top of a file."""
    tree = ast.parse(file.read_text("utf-8"))
    return {n.name for n in tree.body if isinstance(n, ast.FunctionDef | ast.ClassDef)}


def anchors(page: Path) -> set[str]:
    """Headings of a page as the targets of links."""
    heads = re.findall(r"^#+ +(.+)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", head.lower()).strip().replace(" ", "-") for head in heads}


def missing_paths(repository: Path) -> list[str]:
    """`page: path` of everything that a page names and nobody has; was-lines are left out."""
    found = []
    for page in documents(repository):
        # A decision may name a file that is gone, with the word "was" in the same line.
        gone = page.parent.name == "adr"
        for line in page.read_text("utf-8").splitlines():
            if gone and re.search(r"\bwas\b", line):
                continue
            found += [
                f"{page.relative_to(repository)}: {path}"
                for path in named_paths(line)
                if not exists(repository, path)
            ]
    return found


def test_paths_exist(repository: Path) -> None:
    examples = {f"CONTRIBUTING.md: {file}" for file in recipe_files(repository)}
    assert not set(missing_paths(repository)) - examples


def test_links_have_a_target(repository: Path) -> None:
    missing = []
    for page in documents(repository):
        text = page.read_text("utf-8")
        for target, anchor in LINK.findall(text):
            file = page.parent / target
            if not file.exists() or (anchor and anchor not in anchors(file)):
                missing.append(f"{page.relative_to(repository)}: {target}#{anchor}")
        missing += [f"{page.name}: #{a}" for a in ANCHOR.findall(text) if a not in anchors(page)]
    assert not missing


def test_functions_of_the_walk_exist(repository: Path) -> None:
    text = (repository / "docs" / "architecture.md").read_text("utf-8")
    named = FUNCTION.findall(text)
    assert len(named) > 20
    missing = [f"{n} in {f}" for n, f in named if n not in defined(repository / f)]
    assert not missing


def test_every_page_is_in_the_index(repository: Path) -> None:
    index = (repository / "docs" / "README.md").read_text("utf-8")
    pages = [*repository.glob("docs/*.md"), *repository.glob("docs/adr/*.md")]
    names = [page.relative_to(repository / "docs").as_posix() for page in pages]
    assert [n for n in names if n != "README.md" and f"({n}" not in index] == []


def test_missing_paths_are_found(tmp_path: Path) -> None:
    (tmp_path / "docs" / "adr").mkdir(parents=True)
    (tmp_path / "solver").mkdir()
    (tmp_path / "solver" / "a.py").touch()
    (tmp_path / "docs" / "x.md").write_text("`solver/a.py` solver/gone.py, docs/adr/0001.\n")
    (tmp_path / "docs" / "adr" / "0001-b.md").write_text("solver/b.py was here\nsolver/c.py\n")
    assert missing_paths(tmp_path) == [
        "docs/adr/0001-b.md: solver/c.py",
        "docs/x.md: solver/gone.py",
    ]


@pytest.mark.parametrize("text", ["/modal_package/tests/a", "build/solver/x", "xsolver/y"])
def test_parts_of_longer_paths_are_left_out(text: str) -> None:
    assert list(named_paths(text)) == []
