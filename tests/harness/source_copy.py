"""A copy of the sources with a file more, and programs that run on it."""

import os
import re
import shutil
from pathlib import Path

from harness.processes import this_python

HALVES = ("solver", "preprocess", "meshes")
BLOCK = re.compile(r"```python\n# (\S+)\n(.*?)```", re.S)
LINE = re.compile(r"```python\n# in (\w+) of (\S+)\n(.*?)```", re.S)


def recipe_files(repository: Path) -> dict[str, str]:
    """File -> text, of the complete examples in CONTRIBUTING.md."""
    return dict(BLOCK.findall((repository / "CONTRIBUTING.md").read_text("utf-8")))


def recipe_lines(repository: Path) -> list[tuple[str, str, str]]:
    """Table, file and lines that an example of CONTRIBUTING.md adds to it."""
    return LINE.findall((repository / "CONTRIBUTING.md").read_text("utf-8"))


def copy_with_recipes(repository: Path, folder: Path) -> Path:
    """Copy the sources into a folder, follow all recipes there, return the folder."""
    for half in HALVES:  # with their bytecode: times of files stay, so it is valid
        shutil.copytree(repository / half, folder / half)
    (folder / "plymotion").mkdir()
    shutil.copy(repository / "plymotion/__init__.py", folder / "plymotion")
    for name, text in recipe_files(repository).items():
        file = folder / name
        assert not file.exists(), name
        file.write_text(text, encoding="utf-8")
    for table, name, lines in recipe_lines(repository):
        text = (folder / name).read_text("utf-8")
        assert text.count(f"{table} = {{\n") == 1, (table, name)
        (folder / name).write_text(text.replace(f"{table} = {{\n", f"{table} = {{\n{lines}"))
    return folder


def run_python(copy: Path, repository: Path, *arguments: str) -> str:
    """Run Python on the copy, with the helpers of tests/; return what it prints."""
    path = os.pathsep.join([str(copy), str(repository / "tests")])
    done = this_python(*arguments, cwd=copy, more={"PYTHONPATH": path, "PLYMOTION_COMPILED": "0"})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
