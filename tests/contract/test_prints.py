"""Only the command line prints; the library logs, under the name "plymotion"."""

import ast
import logging
from pathlib import Path

import pytest

from plymotion.solver.studies.exit_codes import shown

PRINTERS = ("solver/__main__.py", "solver/commands/")


def prints(text: str) -> list[int]:
    """Lines that call print, or take it as a function."""
    if "print" not in text:
        return []  # parsing takes longer
    names = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name))
    return sorted(node.lineno for node in names if node.id == "print")


def test_only_the_command_line_prints(repository: Path) -> None:
    found = {}
    for path in (repository / "solver").rglob("*.py"):
        name = path.relative_to(repository).as_posix()
        if not name.startswith(PRINTERS) and (lines := prints(path.read_text("utf-8"))):
            found[name] = lines
    assert not found


def test_prints_are_found() -> None:
    assert prints('x = 1\nprint(x)\nwrite = print\n"print(x)"\n') == [2, 3]


def test_messages_are_shown_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    logger = logging.getLogger("plymotion.solver.run.execution")
    for steps in (True, False):
        with shown(steps=steps):
            logger.info("half of %d %%", 100)
            logger.warning("full disk")
        logger.info("nobody listens")
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "half of 100 %\nfull disk\nfull disk\n"
