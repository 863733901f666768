"""What the pages tell a user to type: commands that exist, excerpts of files that are there."""

import re
import shlex
from pathlib import Path

import pytest

from plymotion.solver.__main__ import parser

FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^(?:    |\t)?(?:\.venv/bin/)?(plymotion [^\n]*|make [^\n]*)$", re.MULTILINE)
# Excerpts of a tutorial, and where they come from.
TUTORIALS = {
    "robot-arm.md": "cases/robot-arm/*.toml",
    "antenna-panel.md": "cases/antenna-panel/*.toml",
    "section.md": "cases/sections/box-layup-2.toml",
}


def pages(repository: Path) -> list[Path]:
    found = [p for p in (repository / "docs").rglob("*.md") if p.parent.name != "adr"]
    return [repository / "README.md", repository / "CONTRIBUTING.md", *sorted(found)]


def commands(repository: Path) -> list[tuple[str, str]]:
    """Name of the page and text of every command that stands on a line of its own."""
    found = []
    for page in pages(repository):
        text = page.read_text("utf-8")
        code = [block for kind, block in FENCED.findall(text) if kind in ("", "sh", "bash")]
        rest = FENCED.sub("", text)
        code += ["\n".join(line for line in rest.splitlines() if line.startswith("    "))]
        found += [(page.name, line) for block in code for line in COMMAND.findall(block)]
    return found


def words_of(line: str) -> list[str]:
    """Words of a command; of alternatives the first, without what is optional."""
    line = re.sub(r"\s*\[[^]]*\]", "", line)  # [more files]
    line = re.sub(r"(\S+?)\|\S+", r"\1", line)  # a|b|c
    line = re.sub(r"\$\w+", "1", line)
    line = re.split(r"\s+(?:#|>|\||&&)\s*|\s{3,}", line)[0]
    return [word for word in shlex.split(line) if word != "..."]


def test_commands_of_the_pages_are_understood(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [each for each in commands(repository) if each[1].startswith("plymotion ")]
    assert len(lines) > 40
    wrong = []
    for page, line in lines:
        words = words_of(line)[1:]
        if words and words[0].endswith(".toml"):
            words = ["run", *words]
        try:
            parser().parsed(words)
        except SystemExit as end:
            if end.code:
                wrong.append(f"{page}: {line}: {capsys.readouterr().err.splitlines()[-1]}")
    assert wrong == []


def test_targets_of_the_pages_exist(repository: Path) -> None:
    makefile = (repository / "Makefile").read_text("utf-8")
    phony = {
        name for line in re.findall(r"^\.PHONY: (.*)", makefile, re.M) for name in line.split()
    }
    cases = {path.parent.name for path in repository.glob("cases/*/case.toml")}
    cases |= {f"section-{path.stem}" for path in repository.glob("cases/sections/*.toml")}
    cases |= {f"shell-{path.stem}" for path in repository.glob("cases/shells/*.toml")}
    wrong = []
    for page, line in commands(repository):
        if not line.startswith("make "):
            continue
        for word in words_of(line)[1:]:
            name = word.partition("-sweep-")[0]
            if not (word.startswith("-") or "=" in word or word.isupper() or name in phony | cases):
                wrong.append(f"{page}: {line}: {word}")
    assert wrong == []


@pytest.mark.parametrize("name", TUTORIALS)
def test_excerpts_of_a_tutorial_are_in_its_files(repository: Path, name: str) -> None:
    files = repository.glob(TUTORIALS[name])
    known = {line.partition("#")[0].strip() for f in files for line in f.read_text().splitlines()}
    text = (repository / "docs/tutorials" / name).read_text("utf-8")
    wrong = []
    for kind, block in FENCED.findall(text):
        lines = [line.partition("#")[0].strip() for line in block.splitlines()]
        if kind != "toml" or "[bodies.arm]" in lines:  # an example of the page alone
            continue
        wrong += [line for line in lines if line and line not in known]
    assert wrong == []


def test_what_is_to_be_installed_is_in_an_index(repository: Path) -> None:
    """`plymotion[EXTRA]` is not, before the first release; the libraries of an extra are."""
    sources = [p for f in ("solver", "plymotion") for p in (repository / f).rglob("*.py")]
    for page in [*sources, *pages(repository)]:
        assert not re.search(r"pip install '?plymotion\[", page.read_text("utf-8")), page
