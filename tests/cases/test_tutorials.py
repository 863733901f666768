"""Tutorials followed as they are written: files saved, commands typed, parts of cases compared.

Plain runs of cases and starters are left to `make test-cases` and test_new_command.py, which give
the same commands.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.commands.case_arguments import STARTERS
from plymotion.solver.workers.launch import kept_preprocessors

# "Save as `NAME`" and the block after it, another block of TOML, or an indented command.
STEP = re.compile(
    r"Save as `(?P<name>[^`]+)`[^\n]*\n\n```toml\n(?P<saved>.*?)^```"
    r"|^```toml\n(?P<part>.*?)^```"
    r"|^    (?P<command>(?:\.venv/bin/plymotion|plymotion|ccx) [^\n]*)$",
    re.MULTILINE | re.DOTALL,
)
NUMBER = re.compile(r"-?\d\.\d+e[+-]\d+")
CASES = (path.parent.name for path in Path(__file__).parents[2].glob("cases/*/case.toml"))
PLAIN_RUNS = [[f"{n}/case.toml"] for n in (*(f"cases/{case}" for case in CASES), *STARTERS)]
TUTORIALS = ("antenna-panel", "bracket", "design", "foreign-body", "robot-arm", "section")


@pytest.mark.parametrize("name", TUTORIALS)
def test_tutorial(
    name: str,
    repository: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    fenicsx: str,
) -> None:
    page = repository / "docs/tutorials" / f"{name}.md"
    for folder in ("cases", "meshes"):
        shutil.copytree(repository / folder, tmp_path / folder)
    for file in page.parent.glob("*.inp"):
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    steps = list(STEP.finditer(page.read_text("utf-8")))
    with kept_preprocessors():
        for step in steps:
            if step["name"]:
                Path(step["name"]).write_text(step["saved"], "utf-8")
            elif step["command"]:
                _follow(step["command"].split("  #")[0].split())
    if name == "section":
        _has_the_stiffness(page.read_text("utf-8"), capsys.readouterr().out)
    lines = _lines(tmp_path)
    for step in steps:
        missing = [x for x in (step["part"] or "").splitlines() if _bare(x) not in lines]
        assert not missing, f"{page.name} shows lines that no file of its case has: {missing}"


def test_every_tutorial_is_followed(repository: Path) -> None:
    assert {path.stem for path in (repository / "docs/tutorials").glob("*.md")} == {*TUTORIALS}


def _follow(words: list[str]) -> None:
    program, *arguments = words
    if program == "ccx":
        if shutil.which("ccx") is None:
            pytest.skip("CalculiX is not installed")
        subprocess.run(words, check=True, capture_output=True)
    elif arguments in PLAIN_RUNS:
        assert main(["check", *arguments]) == 0, " ".join(words)
    elif "--sweep" not in arguments:  # 30 s of CPU; sweeps have tests of their own
        # Cases of the repository are tested in their coarse version, as everywhere.
        case = arguments[1] if arguments[0] == "optimise" else arguments[0]
        coarse = ["--coarse"] if case.startswith("cases/") else []
        quiet = [] if arguments[0] in ("new", "info", "export") else ["--quiet"]
        assert main([*arguments, *coarse, *quiet]) == 0, " ".join(words)


def _has_the_stiffness(page: str, printed: str) -> None:
    """The rows of F and M1 in the page are those that the command prints."""
    shown = [line for line in page.splitlines() if line.startswith("    F") or "M1 [N m]" in line]
    assert len(shown) == 4
    for line in shown:
        row = line.split("]")[0].strip()
        mine = next(x for x in printed.splitlines() if x.strip().startswith(row))
        expected = [float(x) for x in NUMBER.findall(line)]
        # Digits depend on the version of gmsh.
        assert [float(x) for x in NUMBER.findall(mine)] == pytest.approx(expected, rel=1e-3)


def _lines(folder: Path) -> set[str]:
    """Lines of all input files below a folder."""
    files = [path for path in folder.rglob("*.toml") if "build" not in path.parts]
    return {_bare(line) for path in files for line in path.read_text("utf-8").splitlines()}


def _bare(line: str) -> str:
    """A line without the comment behind it."""
    return line.split("  #")[0].rstrip()
