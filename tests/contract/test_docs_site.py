"""The documentation site: all pages are in its contents, and its links and examples are right."""

import re
import sys
import tomllib
from pathlib import Path

import pytest

from plymotion.solver.inputs.case.load import load_case

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^][]*\]\(([^)#\s:]+)(?:#[^)\s]*)?\)")


@pytest.fixture(scope="module")
def site(repository, tmp_path_factory) -> Path:
    sys.path.insert(0, str(repository / "tools" / "site"))
    try:
        from layout import lay_out
    finally:
        sys.path.pop(0)
    folder = tmp_path_factory.mktemp("site")
    lay_out(folder)
    return folder


def pages(folder: Path) -> list[Path]:
    return [p for p in folder.rglob("*.md") if "files" not in p.relative_to(folder).parts]


def test_links_stay_inside_the_site(site):
    missing = []
    for page in pages(site):
        text = BLOCK.sub("", page.read_text("utf-8"))
        missing += [
            f"{page.name}: {t}" for t in LINK.findall(text) if not (page.parent / t).exists()
        ]
    assert missing == []


def test_every_page_is_in_the_contents(site, repository):
    parts = tomllib.loads((repository / "tools/site/contents.toml").read_text("utf-8"))
    listed = {
        found for names in parts.values() for name in names for found in site.glob(f"{name}.md")
    }
    assert set(pages(site)) - listed == {site / "index.md"}


def blocks(repository: Path, language: str) -> list[tuple[str, str]]:
    files = [repository / "README.md", *sorted((repository / "docs").rglob("*.md"))]
    return [
        (file.name, text)
        for file in files
        for kind, text in BLOCK.findall(file.read_text("utf-8"))
        if kind == language
    ]


def test_toml_of_the_pages_is_valid(repository):
    found = blocks(repository, "toml")
    assert len(found) > 10
    for name, text in found:
        try:
            tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            pytest.fail(f"{name}: {error}\n{text}")


def test_cases_of_the_pages_are_accepted(repository, tmp_path):
    cases = [(name, text) for name, text in blocks(repository, "toml") if "\n[runs.base]" in text]
    cases = [(name, text) for name, text in cases if text.startswith("format = 1\ntitle")]
    assert {name for name, _ in cases} >= {"first-steps.md"}
    (tmp_path / "cases").symlink_to(repository / "cases")  # pages are followed in the repository
    for number, (_, text) in enumerate(cases):
        file = tmp_path / f"case-{number}.toml"
        file.write_text(text, encoding="utf-8")
        assert load_case(file).runs


def test_python_of_the_pages_compiles(repository):
    found = blocks(repository, "python")
    assert found
    for name, text in found:
        compile(text, name, "exec")
