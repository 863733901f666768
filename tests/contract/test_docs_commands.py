"""What the pages tell a user to type: commands, options and keys that exist."""

import re
import shlex
import tomllib
from pathlib import Path
from textwrap import dedent

import pytest
from jsonschema import Draft202012Validator

from plymotion.solver.__main__ import parser
from plymotion.solver.inputs.json_schema import KINDS, json_schema

FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"(?:^    .*\n|^\n(?=    ))+", re.MULTILINE)
COMMAND = re.compile(r"^(?:    |\t)?(?:\.venv/bin/)?(plymotion [^\n]*|make [^\n]*)$", re.MULTILINE)


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


def test_parts_of_input_files_have_keys_and_values_that_exist(repository: Path) -> None:
    """Each is a part of a case, a section, a shell or a solid."""
    kinds = [Draft202012Validator(json_schema(kind)) for kind in KINDS]
    wrong, found = [], 0
    for page in pages(repository):
        text = page.read_text("utf-8")
        parts = [part for kind, part in FENCED.findall(text) if kind == "toml"]
        indented = [dedent(part).strip() for part in INDENTED.findall(FENCED.sub("", text))]
        for table in map(tomllib.loads, [*parts, *(p for p in indented if p.startswith("["))]):
            if "from" in table:  # a body of another code: no schema
                continue
            if "minimise" in table:
                table = {"design": {"studies": {"front": table}}}
            errors = [[e for e in k.iter_errors(table) if e.validator != "required"] for k in kinds]
            wrong += [f"{page.name}: {min(errors, key=len)[0].message}"] if all(errors) else []
            found += 1
    assert found > 50
    assert wrong == []


def test_what_is_to_be_installed_is_in_an_index(repository: Path) -> None:
    """`plymotion[EXTRA]` is not, before the first release; the libraries of an extra are."""
    sources = [p for f in ("solver", "plymotion") for p in (repository / f).rglob("*.py")]
    for page in [*sources, *pages(repository)]:
        assert not re.search(r"pip install '?plymotion\[", page.read_text("utf-8")), page
